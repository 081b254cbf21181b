from dataclasses import dataclass
from typing import Any
@dataclass
class Pose:
    rotation: Any
    centre: Any
    densities: Any
def check_pose(*a): pass
