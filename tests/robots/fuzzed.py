"""Damaged descriptions of arms: URDFs, and YAML of the library."""

import random
from pathlib import Path
from xml.etree.ElementTree import Element, fromstring, tostring

import yaml

from tests.damage import damaged_file
from tests.damaged_values import other_value
from tests.fuzz import Attempt
from tests.robots.test_from_urdf import made_up
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.from_urdf import robot_from_urdf

TEXTS = ("", "x", "nan", "1e300", "-1", "0", "0 0 0", "1 2", "1e999 0 0", "link_1", "fixed", "base")


def urdfs(folder: Path) -> Attempt:
    """Return what describes the arm of a damaged URDF."""
    whole = tostring(made_up(6))

    def attempt(draw: random.Random, place: Path) -> None:
        file = place / "arm.urdf"
        if draw.random() < 0.3:
            file.write_bytes(damaged_file(whole, draw).data)
        else:
            root = fromstring(whole)
            for _ in range(draw.randint(1, 3)):
                change(root, draw)
            file.write_bytes(tostring(root))
        robot_from_urdf(file)

    return attempt


def change(root: Element, draw: random.Random) -> None:
    """Change an element: an attribute, or the element is lost or there twice."""
    parent = draw.choice([one for one in root.iter() if len(one)])
    child = draw.choice([*parent])
    match draw.choice(["lost", "twice", "attribute", "attribute", "attribute"]):
        case "lost":
            parent.remove(child)
        case "twice":
            parent.append(child)
        case _ if child.attrib:
            key = draw.choice([*child.attrib])
            child.set(key, draw.choice(TEXTS))


def descriptions(folder: Path) -> Attempt:
    """Return what reads a damaged description."""
    wholes = [robot_path(name).read_text() for name in ("ur5", "ur10e", "kuka-kr300")]

    def attempt(draw: random.Random, place: Path) -> None:
        text, file = draw.choice(wholes), place / "arm.yaml"
        if draw.random() < 0.3:
            file.write_bytes(damaged_file(text.encode(), draw).data)
        else:
            file.write_text(yaml.safe_dump(other_value(yaml.safe_load(text), draw)))
        load_robot(file)

    return attempt


TARGETS = {"URDFs": urdfs, "descriptions": descriptions}
