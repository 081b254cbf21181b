"""Write the JSON Schemas that ship in the wheel from the models that read the files."""

from __future__ import annotations

import json
from pathlib import Path

from cdpr_interval.files.fields import schema_of
from cdpr_interval.robots.formats.schema import json_schema
from cdpr_interval.robots.formats.winch_schema import RobotWithWinches
from solvers.batch.job_schema import BATCH_FORMAT, BatchBlock

ROOT = Path(__file__).parents[1]


def schemas() -> dict[str, str]:
    """Return the text of each schema file by its place in the repository."""
    models = {
        "cdpr_interval/robots/schemas/cdpr-robot-1.schema.json": json_schema(RobotWithWinches),
        "solvers/schemas/cdpr-batch-1.schema.json": schema_of(BatchBlock, BATCH_FORMAT),
    }
    return {name: json.dumps(schema, indent=1) + "\n" for name, schema in models.items()}


def main() -> None:
    """Write every file."""
    for name, text in schemas().items():
        (ROOT / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
