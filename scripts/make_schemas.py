"""Write the JSON Schemas that ship in the wheel from the models that read the files."""

from __future__ import annotations

import json
from pathlib import Path

from cdpr_interval.robots.schema import json_schema
from cdpr_interval.robots.winch_schema import RobotWithWinches

FOLDER = Path(__file__).parents[1] / "cdpr_interval" / "robots" / "schemas"


def schemas() -> dict[str, str]:
    """Return the text of each schema file by its name."""
    return {"cdpr-robot-1.schema.json": json.dumps(json_schema(RobotWithWinches), indent=1) + "\n"}


def main() -> None:
    """Write every file."""
    FOLDER.mkdir(exist_ok=True)
    for name, text in schemas().items():
        (FOLDER / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
