"""Write the JSON Schemas that ship in the wheel from the models of the files, and the pages about them."""

from __future__ import annotations

import json
import sys
from pathlib import Path

# Run from anywhere: what writes the pages lies in this folder.
sys.path.insert(0, str(Path(__file__).resolve().parent))

import format_pages

from cdpr_interval.files.fields import schema_of
from cdpr_interval.robots.formats.delta_schema import json_schema as delta_schema
from cdpr_interval.robots.formats.mechanism_schema import json_schema as mechanism_schema
from cdpr_interval.robots.formats.schema import json_schema
from cdpr_interval.robots.formats.winch_schema import RobotWithWinches
from solvers.answers.data import FORMAT, ResultData
from solvers.answers.document import schema_of as result_schema
from solvers.answers.inverse import FORMAT as IK_FORMAT
from solvers.answers.inverse import IkData
from solvers.batch.job_schema import BATCH_FORMAT, BatchBlock
from solvers.delta.data import FORMAT as DELTA_FORMAT
from solvers.delta.data import IK_FORMAT as DELTA_IK_FORMAT
from solvers.delta.data import DeltaIkData, DeltaResultData
from solvers.delta.kinematics_data import FORMAT as KINEMATICS_FORMAT
from solvers.delta.kinematics_data import DeltaKinematics
from solvers.motions.data import FORMAT as MOTION_FORMAT
from solvers.motions.data import MotionData
from solvers.questions.problem_schema import PROBLEM_FORMAT, ProblemBlock

ROOT = Path(__file__).parents[1]


def schemas() -> dict[str, str]:
    """Return the text of each schema file by its place in the repository."""
    models = {
        "cdpr_interval/robots/schemas/cdpr-robot-1.schema.json": json_schema(RobotWithWinches),
        "cdpr_interval/robots/schemas/delta-robot-1.schema.json": delta_schema(),
        "cdpr_interval/robots/schemas/mechanism-1.schema.json": mechanism_schema(),
        "solvers/schemas/cdpr-batch-1.schema.json": schema_of(BatchBlock, BATCH_FORMAT),
        "solvers/schemas/cdpr-delta-ik-result-1.schema.json": result_schema(DeltaIkData, DELTA_IK_FORMAT),
        "solvers/schemas/cdpr-delta-result-1.schema.json": result_schema(DeltaResultData, DELTA_FORMAT),
        "solvers/schemas/cdpr-ik-result-1.schema.json": result_schema(IkData, IK_FORMAT),
        "solvers/schemas/cdpr-kinematics-result-1.schema.json": result_schema(
            DeltaKinematics, KINEMATICS_FORMAT
        ),
        "solvers/schemas/cdpr-motion-1.schema.json": result_schema(MotionData, MOTION_FORMAT),
        "solvers/schemas/cdpr-problem-1.schema.json": schema_of(ProblemBlock, PROBLEM_FORMAT),
        "solvers/schemas/cdpr-result-1.schema.json": result_schema(ResultData, FORMAT),
    }
    return {name: json.dumps(schema, indent=1) + "\n" for name, schema in models.items()}


def main() -> None:
    """Write every file."""
    for name, text in schemas().items():
        (ROOT / name).write_text(text, encoding="utf-8")
    format_pages.main()


if __name__ == "__main__":
    main()
