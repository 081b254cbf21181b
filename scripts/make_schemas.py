"""Write the JSON Schemas that ship in the wheel from the models of the files, and the pages about them."""

from __future__ import annotations

import json
import sys
from pathlib import Path

# Run from anywhere: what writes the pages lies in this folder.
sys.path.insert(0, str(Path(__file__).resolve().parent))

import format_pages

from cdpr_interval.files.fields import schema_of
from cdpr_interval.robots.formats.schema import json_schema
from cdpr_interval.robots.formats.winch_schema import RobotWithWinches
from solvers.answers.data import FORMAT, ResultData
from solvers.answers.document import schema_of as result_schema
from solvers.answers.inverse import FORMAT as IK_FORMAT
from solvers.answers.inverse import IkData
from solvers.batch.job_schema import BATCH_FORMAT, BatchBlock
from solvers.motions.data import FORMAT as MOTION_FORMAT
from solvers.motions.data import MotionData
from solvers.questions.problem_schema import PROBLEM_FORMAT, ProblemBlock

ROOT = Path(__file__).parents[1]


def schemas() -> dict[str, str]:
    """Return the text of each schema file by its place in the repository."""
    models = {
        "cdpr_interval/robots/schemas/cdpr-robot-1.schema.json": json_schema(RobotWithWinches),
        "solvers/schemas/cdpr-batch-1.schema.json": schema_of(BatchBlock, BATCH_FORMAT),
        "solvers/schemas/cdpr-ik-result-1.schema.json": result_schema(IkData, IK_FORMAT),
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
