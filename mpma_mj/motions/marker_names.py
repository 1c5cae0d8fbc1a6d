"""What shoulders, elbows, wrists, pelvis and neck are called in recordings."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

__all__ = ["ACCLAIM", "ACCLAIM_PELVIS", "SETS", "TORSO", "Words", "common_prefix", "short_name"]

# Words for shoulder, elbow and wrist, without the side. Of each column the first that is there
# is taken; sets are tried in turn, skeletons first: their "shoulder" is often the collar bone.
Words = tuple[tuple[str, ...], ...]
SETS: tuple[tuple[Words, Words, Words], ...] = (
    # CMU's BVH, Mixamo, MotionBuilder, Rokoko
    ((("arm",),), (("forearm",),), (("hand",),)),
    # Biped, Unity, Unreal, Xsens, Bandai-Namco, OptiTrack's bones
    (
        (("upperarm",), ("uparm",), ("uarm",)),
        (("forearm",), ("lowerarm",), ("lowarm",), ("farm",), ("fore arm",)),
        (("hand",), ("wrist",)),
    ),
    # Poser, DAZ, indian_13
    ((("shldr",), ("shldrbend",)), (("forearm",), ("forearmbend",)), (("hand",),)),
    # Acclaim: a bone is where it begins, and the forearm ends with the bone "wrist"; CMU's BVH
    # has its neck where the thorax begins, so both give one torso
    ((("humerus",),), (("radius",),), (("wristend",),)),
    # Markers and joint centres: Plug-in Gait, HDM05, Qualisys, ISB, OptiTrack, Kinect, Captury
    (
        (
            *(("sho",), ("saj",), ("acr",), ("acromion",), ("acrom",), ("acj",), ("ac",)),
            *(("shouldertop",), ("shouldertip",), ("shoulder",), ("shoulderjc",), ("sjc",)),
        ),
        (
            *(("hle", "hme"), ("lhe", "mhe"), ("lepi", "mepi"), ("epil", "epim")),
            *(("elbl", "elbm"), ("lel", "mel"), ("elblat", "elbmed"), ("elbowlat", "elbowmed")),
            *(("latelbow", "medelbow"), ("elbowlateral", "elbowmedial"), ("epicl", "epicm")),
            *(("elbowout", "elbowin"), ("elb", "elbm"), ("elb", "elbi"), ("elb", "melb")),
            *(("elb",), ("elbow",), ("elbowout",), ("elbowjc",), ("ejc",)),
        ),
        (
            *(("wra", "wrb"), ("rsp", "usp"), ("rsp", "uhe"), ("stylr", "stylu")),
            *(("wristin", "wristout"), ("wristinner", "wristouter"), ("radius", "ulna")),
            *(("rad", "uln"), ("wrl", "wrm"), ("wrr", "wru"), ("wristlat", "wristmed")),
            *(("iwr", "owr"), ("rs", "us"), ("wri",), ("wrist",), ("wristjc",), ("wjc",)),
        ),
    ),
)
# Of Acclaim's skeletons alone: elsewhere a root may stand still on the floor.
ACCLAIM, ACCLAIM_PELVIS = "lhumerus", ("root",)
TORSO: dict[str, Words] = {
    "pelvis": (
        *(("lasi", "rasi", "lpsi", "rpsi"), ("lfwt", "rfwt", "lbwt", "rbwt")),
        *(("lias", "rias", "lips", "rips"), ("lasis", "rasis", "lpsis", "rpsis")),
        *(("hipfl", "hipfr", "hipbl", "hipbr"), ("asisl", "asisr", "psisl", "psisr")),
        ("waistlfront", "waistrfront", "waistlback", "waistrback"),
        *(("lasi", "rasi", "sacr"), ("hips",), ("pelvis",), ("midhip",), ("hip",)),
        *(("lpsi", "rpsi"), ("lasi", "rasi"), ("lbwt", "rbwt"), ("lfwt", "rfwt")),
        *(("lips", "rips"), ("lias", "rias"), ("lpsis", "rpsis"), ("lasis", "rasis")),
        ACCLAIM_PELVIS,
        *(("lefthip", "righthip"), ("hipleft", "hipright"), ("lhip", "rhip"), ("hipl", "hipr")),
    ),
    "neck": (
        *(("c7", "clav"), ("cv7", "snj"), ("c7", "ij"), ("thorax",), ("neck",)),
        *(("neck01",), ("spineshoulder",)),
    ),
}
# Parts of names that say nothing about which point it is.
_PREFIX = re.compile(r"^mixamorig\d*")
_SUFFIX = re.compile(r"(positions?|pos|jointcent(er|re))$")


def common_prefix(names: Sequence[str]) -> str:
    """Return the beginning that most names share, such as "Bip01 ", or ""."""
    starts = [re.match(r"[^\W_]+[\W_]+", name.rpartition(":")[2]) for name in names]
    prefix, count = Counter(start[0] if start else "" for start in starts).most_common(1)[0]
    is_side = re.fullmatch(r"(l|r|left|right)[\W_]+", prefix.lower())
    return prefix if 5 * count > 3 * len(names) and not is_side else ""


def short_name(name: str) -> str:
    """Return a name without subject, case, separators and what says nothing."""
    letters = re.sub(r"[\W_]+", "", name.rpartition(":")[2].lower())
    return _SUFFIX.sub("", _PREFIX.sub("", letters))
