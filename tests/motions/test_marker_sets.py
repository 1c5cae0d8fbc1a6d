"""Names of points, as many programs give them, are recognised, or can be said by hand."""

import re
from pathlib import Path

import pytest

from mpma_mj.errors import BadOptionError, MotionFileError
from mpma_mj.kinematics import SIDES
from mpma_mj.motions.body import ARM_POINTS
from mpma_mj.motions.import_report import ImportReport
from mpma_mj.motions.mapping import Groups, parse_mapping
from mpma_mj.motions.marker_sets import choose_markers

FILE = Path("dance.c3d")
_PLUG_IN_GAIT = (
    "LFHD RFHD LBHD RBHD C7 T10 CLAV STRN RBAK LSHO LUPA LELB LFRM LWRA LWRB LFIN RSHO RUPA RELB"
    " RFRM RWRA RWRB RFIN LASI RASI LPSI RPSI LTHI LKNE LTIB LANK"
)
# A file's names; then left shoulder, elbow, wrist, then the right ones, with + between several.
KNOWN = {
    "Plug-in Gait": (_PLUG_IN_GAIT, "LSHO LELB LWRA+LWRB RSHO RELB RWRA+RWRB"),
    "CMU": (
        "LFWT RFWT LBWT RBWT C7 T8 CLAV STRN LSHO LUPA LELB LWRA LWRB LFIN RSHO RELB RWRA RWRB",
        "LSHO LELB LWRA+LWRB RSHO RELB RWRA+RWRB",
    ),
    "Qualisys": (
        "Head_L Shoulder_L Elbow_L Radius_L Ulna_L Hip_FL Shoulder_R Elbow_R Radius_R Ulna_R",
        "Shoulder_L Elbow_L Radius_L+Ulna_L Shoulder_R Elbow_R Radius_R+Ulna_R",
    ),
    "ISB": (
        "L_SAJ L_HLE L_HME L_RSP L_UHE R_SAJ R_HLE R_HME R_RSP R_UHE L_IAS R_IAS",
        "L_SAJ L_HLE+L_HME L_RSP+L_UHE R_SAJ R_HLE+R_HME R_RSP+R_UHE",
    ),
    "ISB, side first": (
        "LACR LHLE LHME LRSP LUSP RACR RHLE RHME RRSP RUSP",
        "LACR LHLE+LHME LRSP+LUSP RACR RHLE+RHME RRSP+RUSP",
    ),
    "CMU BVH": (
        "Hips LHipJoint Neck LeftShoulder LeftArm LeftForeArm LeftHand LeftHand_end RightShoulder"
        " RightArm RightForeArm RightHand",
        "LeftArm LeftForeArm LeftHand RightArm RightForeArm RightHand",
    ),
    "Mixamo": (
        "mixamorig:Hips mixamorig:LeftShoulder mixamorig:LeftArm mixamorig:LeftForeArm"
        " mixamorig:LeftHand mixamorig:RightShoulder mixamorig:RightArm mixamorig:RightForeArm"
        " mixamorig:RightHand",
        "mixamorig:LeftArm mixamorig:LeftForeArm mixamorig:LeftHand mixamorig:RightArm"
        " mixamorig:RightForeArm mixamorig:RightHand",
    ),
    "Mixamo with a line": (
        "mixamorig_Hips mixamorig_LeftShoulder mixamorig_LeftArm mixamorig_LeftForeArm"
        " mixamorig_LeftHand mixamorig_RightArm mixamorig_RightForeArm mixamorig_RightHand",
        "mixamorig_LeftArm mixamorig_LeftForeArm mixamorig_LeftHand mixamorig_RightArm"
        " mixamorig_RightForeArm mixamorig_RightHand",
    ),
    "Bandai-Namco": (
        "joint_Root Hips Spine Chest Neck Head Shoulder_L UpperArm_L LowerArm_L Hand_L Shoulder_R"
        " UpperArm_R LowerArm_R Hand_R UpperLeg_L LowerLeg_L",
        "UpperArm_L LowerArm_L Hand_L UpperArm_R LowerArm_R Hand_R",
    ),
    "MediaPipe": (
        "NOSE LEFT_SHOULDER RIGHT_SHOULDER LEFT_ELBOW RIGHT_ELBOW LEFT_WRIST RIGHT_WRIST"
        " LEFT_PINKY RIGHT_PINKY LEFT_HIP RIGHT_HIP",
        "LEFT_SHOULDER LEFT_ELBOW LEFT_WRIST RIGHT_SHOULDER RIGHT_ELBOW RIGHT_WRIST",
    ),
    "Kinect": (
        "SpineBase SpineMid Neck Head ShoulderLeft ElbowLeft WristLeft HandLeft ShoulderRight"
        " ElbowRight WristRight HandRight SpineShoulder",
        "ShoulderLeft ElbowLeft WristLeft ShoulderRight ElbowRight WristRight",
    ),
    "Captury": (
        "CenterOfGravity LWristPositions LElbowPositions LShoulderPositions RWristPositions"
        " RElbowPositions RShoulderPositions",
        "LShoulderPositions LElbowPositions LWristPositions RShoulderPositions RElbowPositions"
        " RWristPositions",
    ),
    "Poser": (
        "hip abdomen chest neck rCollar rShldr rForeArm rHand lCollar lShldr lForeArm lHand",
        "lShldr lForeArm lHand rShldr rForeArm rHand",
    ),
    "Acclaim": (
        "root root_end thorax lclavicle lhumerus lhumerus_end lradius lradius_end lwrist"
        " lwrist_end rclavicle rhumerus rradius rwrist rwrist_end",
        "lhumerus lradius lwrist_end rhumerus rradius rwrist_end",
    ),
    "Xsens": (
        "Pelvis L5 Neck RightShoulder RightUpperArm RightForeArm RightHand LeftShoulder"
        " LeftUpperArm LeftForeArm LeftHand",
        "LeftUpperArm LeftForeArm LeftHand RightUpperArm RightForeArm RightHand",
    ),
    "Unreal": (
        "pelvis spine_01 neck_01 clavicle_l upperarm_l lowerarm_l hand_l clavicle_r upperarm_r"
        " lowerarm_r hand_r",
        "upperarm_l lowerarm_l hand_l upperarm_r lowerarm_r hand_r",
    ),
    "OpenSim": (
        "pelvis torso humerus_l ulna_l radius_l hand_l humerus_r ulna_r radius_r hand_r",
        "humerus_l ulna_l hand_l humerus_r ulna_r hand_r",
    ),
    "Theia": (
        "pelvis torso l_uarm l_larm l_hand r_uarm r_larm r_hand l_thigh r_thigh",
        "l_uarm l_larm l_hand r_uarm r_larm r_hand",
    ),
    "NITE, without wrists": (
        "ShoulderLeft ElbowLeft HandLeft ShoulderRight ElbowRight HandRight HipLeft HipRight",
        "ShoulderLeft ElbowLeft HandLeft ShoulderRight ElbowRight HandRight",
    ),
    "hands beside wrists": (
        "lcollar lshoulder lelbow lwrist lhand rcollar rshoulder relbow rwrist rhand",
        "lshoulder lelbow lwrist rshoulder relbow rwrist",
    ),
    "segment markers beside joint markers": (
        "LSH LARM LELB LFOREARM LHAND LWR RSH RARM RELB RFOREARM RHAND RWR",
        "LSH LELB LWR RSH RELB RWR",
    ),
    "German": (
        "Schulter_links Ellenbogen_links Handgelenk_links rechte_Schulter rechter_Ellenbogen"
        " rechtes_Handgelenk Becken",
        "Schulter_links Ellenbogen_links Handgelenk_links rechte_Schulter rechter_Ellenbogen"
        " rechtes_Handgelenk",
    ),
    "French": (
        "épaule_gauche coude_gauche poignet_gauche épaule_droite coude_droit poignet_droit",
        "épaule_gauche coude_gauche poignet_gauche épaule_droite coude_droit poignet_droit",
    ),
    "Spanish": (
        "hombro_izq codo_izq muñeca_izq hombro_der codo_der muñeca_der",
        "hombro_izq codo_izq muñeca_izq hombro_der codo_der muñeca_der",
    ),
    "Italian": (
        "spalla_sx gomito_sx polso_sx spalla_dx gomito_dx polso_dx",
        "spalla_sx gomito_sx polso_sx spalla_dx gomito_dx polso_dx",
    ),
    "MikuMikuDance": (
        "左腕 左ひじ 左手首 右腕 右ひじ 右手首",
        "左腕 左ひじ 左手首 右腕 右ひじ 右手首",
    ),
    "ARKit": (
        "hips_joint left_arm_joint left_forearm_joint left_hand_joint right_arm_joint"
        " right_forearm_joint right_hand_joint",
        "left_arm_joint left_forearm_joint left_hand_joint right_arm_joint right_forearm_joint"
        " right_hand_joint",
    ),
    "VRM": (
        "J_Bip_C_Hips J_Bip_L_UpperArm J_Bip_L_LowerArm J_Bip_L_Hand J_Bip_R_UpperArm"
        " J_Bip_R_LowerArm J_Bip_R_Hand",
        "J_Bip_L_UpperArm J_Bip_L_LowerArm J_Bip_L_Hand J_Bip_R_UpperArm J_Bip_R_LowerArm"
        " J_Bip_R_Hand",
    ),
    "snake case": (
        "left_shoulder left_elbow left_wrist right_shoulder right_elbow right_wrist",
        "left_shoulder left_elbow left_wrist right_shoulder right_elbow right_wrist",
    ),
}


def groups_of(text: str) -> Groups:
    return dict(zip(ARM_POINTS, (tuple(p.split("+")) for p in text.split()), strict=True))


def arms(groups: Groups) -> Groups:
    return {point: groups[point] for point in ARM_POINTS}


@pytest.mark.parametrize("kind", KNOWN)
def test_known_names_are_recognised(kind: str) -> None:
    names, expected = KNOWN[kind]
    assert arms(choose_markers(FILE, names.split(), {})) == groups_of(expected)


@pytest.mark.parametrize("kind", KNOWN)
def test_the_order_of_the_names_does_not_matter(kind: str) -> None:
    names, expected = KNOWN[kind]
    assert arms(choose_markers(FILE, names.split()[::-1], {})) == groups_of(expected)


@pytest.mark.parametrize("subject", ["Anna:", "Skeleton 001:", "take:Anna:", "Anna", "P1_"])
@pytest.mark.parametrize("kind", ["Plug-in Gait", "CMU", "ISB", "Xsens"])
def test_a_subject_before_the_names_does_not_matter(kind: str, subject: str) -> None:
    names, expected = KNOWN[kind]
    groups = choose_markers(FILE, [subject + name for name in names.split()], {})
    known = groups_of(expected)
    assert arms(groups) == {p: tuple(subject + n for n in group) for p, group in known.items()}


def test_names_with_spaces_are_recognised() -> None:
    names = ["Bip01", "Bip01 Pelvis", "Bip01 Neck"] + [
        f"Bip01 {side} {bone}"
        for side in "LR"
        for bone in ("Clavicle", "UpperArm", "Forearm", "Hand", "Finger0")
    ]
    groups = choose_markers(FILE, names, {})
    assert groups["left_shoulder"] == ("Bip01 L UpperArm",)
    assert groups["right_wrist"] == ("Bip01 R Hand",)
    assert groups["pelvis"] == ("Bip01 Pelvis",)


def test_optitracks_bones_are_recognised() -> None:
    bones = ("Hip", "Ab", "Chest", "Neck", "LShoulder", "LUArm", "LFArm", "LHand", "LThumb1")
    bones += ("RShoulder", "RUArm", "RFArm", "RHand")
    names = [f"Skeleton 001:{bone}" for bone in bones]
    groups = choose_markers(FILE, names, {})
    shown = [group[0].removeprefix("Skeleton 001:") for group in arms(groups).values()]
    assert shown == ["LUArm", "LFArm", "LHand", "RUArm", "RFArm", "RHand"]


@pytest.mark.parametrize(
    ("kind", "pelvis", "neck"),
    [
        ("Plug-in Gait", "LASI RASI LPSI RPSI", "C7 CLAV"),
        ("CMU", "LFWT RFWT LBWT RBWT", "C7 CLAV"),
        ("CMU BVH", "Hips", "Neck"),
        ("Kinect", "SpineBase", "Neck"),
        ("MediaPipe", "LEFT_HIP RIGHT_HIP", "LEFT_SHOULDER RIGHT_SHOULDER"),
        ("Acclaim", "root", "thorax"),
        ("snake case", None, None),
    ],
)
def test_the_torso_is_found_where_it_is_shown(
    kind: str, pelvis: str | None, neck: str | None
) -> None:
    groups = choose_markers(FILE, KNOWN[kind][0].split(), {})
    if pelvis is None or neck is None:
        assert set(groups) == set(ARM_POINTS)
    else:
        assert groups["pelvis"] == tuple(pelvis.split())
        assert groups["neck"] == tuple(neck.split())


ENGLISH = [f"{side}_{part}" for side in SIDES for part in ("shoulder", "elbow", "wrist")]
GERMAN = "Schulter_links Ellenbogen_links Handgelenk_links Schulter_re Ellenbogen_re Handgelenk_re"


@pytest.mark.parametrize(
    ("names", "pelvis", "neck"),
    [
        (f"{GERMAN} Becken Hals", "Becken", "Hals"),
        (f"{GERMAN} Huefte_links Huefte_rechts Nacken", "Huefte_links Huefte_rechts", "Nacken"),
        (f"{GERMAN} linke_Hüfte rechte_Hüfte Hals", "linke_Hüfte rechte_Hüfte", "Hals"),
        (f"{KNOWN['French'][1]} bassin cou", "bassin", "cou"),
        (
            f"{KNOWN['French'][1]} hanche_gauche hanche_droite cou",
            "hanche_gauche hanche_droite",
            "cou",
        ),
        (f"{KNOWN['Spanish'][1]} pelvis cuello", "pelvis", "cuello"),
        (f"{KNOWN['Spanish'][1]} cadera_izq cadera_der cuello", "cadera_izq cadera_der", "cuello"),
        (f"{KNOWN['Italian'][1]} bacino collo", "bacino", "collo"),
        (f"{KNOWN['Italian'][1]} anca_sx anca_dx collo", "anca_sx anca_dx", "collo"),
        (f"{KNOWN['MikuMikuDance'][1]} 下半身 首", "下半身", "首"),
        (
            "HipCenter ShoulderCenter Spine ShoulderLeft ElbowLeft WristLeft ShoulderRight"
            " ElbowRight WristRight",
            "HipCenter",
            "ShoulderCenter",
        ),
        (
            "J_Bip_L_UpperArm J_Bip_L_LowerArm J_Bip_L_Hand J_Bip_R_UpperArm J_Bip_R_LowerArm"
            " J_Bip_R_Hand J_Bip_C_Hips J_Bip_C_Spine J_Bip_C_Neck",
            "J_Bip_C_Hips",
            "J_Bip_C_Neck",
        ),
        (
            "root torso_1 neck_1 l_up_arm l_low_arm l_hand r_up_arm r_low_arm r_hand",
            "root",
            "neck_1",
        ),
        (f"{' '.join(ENGLISH)} root centerShoulder topHead", "root", "centerShoulder"),
        (f"{KNOWN['ARKit'][1]} root hips_joint neck_1_joint", "hips_joint", "neck_1_joint"),
        (f"{' '.join(ENGLISH)} hips_center neck_center", "hips_center", "neck_center"),
    ],
)
def test_the_torso_is_known_by_name_wherever_the_arms_are(
    names: str, pelvis: str, neck: str
) -> None:
    report = ImportReport()
    groups = choose_markers(FILE, names.split(), {}, report)
    assert (groups["pelvis"], groups["neck"]) == (tuple(pelvis.split()), tuple(neck.split()))
    assert not report.warnings


@pytest.mark.parametrize("spine", ["spine", "lower_back", "Spine1", "waist"])
def test_what_stands_for_the_pelvis_is_told(spine: str) -> None:
    report = ImportReport()
    groups = choose_markers(FILE, [*ENGLISH, spine, "chest"], {}, report)
    assert groups["pelvis"] == (spine,)
    assert groups["neck"] == ("left_shoulder", "right_shoulder")
    (warning,) = report.warnings
    assert warning.startswith(f"{spine} stands for the pelvis")
    assert choose_markers(FILE, [*ENGLISH, spine, "base"], {}, root="base")["pelvis"] == ("base",)
    mapped = ImportReport()
    choose_markers(FILE, [*ENGLISH, spine], {"pelvis": (spine,)}, mapped)
    assert not mapped.warnings


def test_a_root_may_stand_on_the_floor() -> None:
    assert "pelvis" not in choose_markers(FILE, [*ENGLISH, "Root", "Neck"], {})


SEGMENTS = ("upper_arm", "forearm", "hand")


@pytest.mark.parametrize(
    "names",
    [
        [f"{side}_{part}_com" for side in SIDES for part in SEGMENTS],
        [
            f"CoG {side} {part}"
            for side in ("Left", "Right")
            for part in ("UpperArm", "Forearm", "Hand")
        ],
        [
            f"{side}{part}CoM"
            for side in ("Left", "Right")
            for part in ("UpperArm", "Forearm", "Hand")
        ],
        [f"center_of_mass_{part}_{side}" for side in "lr" for part in SEGMENTS],
        [f"{part}_{side}" for side in "lr" for part in ("humerus", "ulna", "hand")]
        + ["center_of_mass"],
    ],
)
def test_centres_of_mass_are_no_joints(names: list[str]) -> None:
    with pytest.raises(
        MotionFileError, match="are centres of mass of segments, which are no joints"
    ):
        choose_markers(FILE, [*names, "pelvis"], {})
    mapping = dict(zip(ARM_POINTS, ((name,) for name in names), strict=False))
    assert choose_markers(FILE, [*names, "pelvis"], mapping).keys() > set(ARM_POINTS)


def test_the_bodys_centre_of_mass_may_stand_beside_joints() -> None:
    for name in ("CenterOfGravity", "center_of_mass", "CoM"):
        assert choose_markers(FILE, [*ENGLISH, name, "pelvis"], {})["left_wrist"] == ("left_wrist",)


@pytest.mark.parametrize("form", ["{}_{}", "{}.{}", "{}{}", "{} {}"])
def test_two_people_may_differ_by_a_number_after_their_names(form: str) -> None:
    names = [form.format(name, i) for i in (1, 2) for name in (*ENGLISH, "pelvis", "neck")]
    with pytest.raises(MotionFileError, match="shows 2 people; choose one with map=") as caught:
        choose_markers(FILE, names, {})
    for i, mapping in enumerate(re.findall(r'map="(.*?)"', str(caught.value)), 1):
        groups = choose_markers(FILE, names, parse_mapping(mapping))
        assert groups["left_wrist"] == (form.format("left_wrist", i),)
        assert groups["pelvis"] == (form.format("pelvis", i),)


ODD = ["ac", "olec", "caput", "dx_ac", "dx_olec", "dx_caput", "knee"]
WHOLE = (
    "left_shoulder=ac,left_elbow=olec,left_wrist=caput,right_shoulder=dx_ac,right_elbow=dx_olec,"
    "right_wrist=dx_caput+knee"
)


def test_a_mapping_names_what_is_not_recognised() -> None:
    groups = choose_markers(FILE, ODD, parse_mapping(WHOLE))
    assert groups["left_elbow"] == ("olec",)
    assert groups["right_wrist"] == ("dx_caput", "knee")


@pytest.mark.parametrize("spaces", [False, True])
def test_a_toml_file_is_a_mapping_too(tmp_path: Path, spaces: bool) -> None:
    path = tmp_path / "mapping.toml"
    lines = [entry.replace("=", ' = "') + '"' for entry in WHOLE.split(",")]
    path.write_text("\n".join(lines).replace("+", " + " if spaces else "+"))
    assert parse_mapping(str(path)) == parse_mapping(WHOLE)


def test_a_toml_mapping_may_hold_lists(tmp_path: Path) -> None:
    path = tmp_path / "mapping.toml"
    path.write_text('left_elbow = ["EPICl", "a+b, c"]')
    assert parse_mapping(str(path)) == {"left_elbow": ("EPICl", "a+b, c")}


def test_spaces_in_a_mapping_do_not_matter() -> None:
    assert parse_mapping(" left_elbow = a + b , ") == {"left_elbow": ("a", "b")}


@pytest.mark.parametrize(
    ("mapping", "message"),
    [
        ("left_knee=LKNE", "has unknown point 'left_knee'; expected left_shoulder"),
        ("left_elbow", "map has 'left_elbow', not POINT=NAME"),
        ("left_elbow=", "'left_elbow=', not POINT=NAME"),
        ("left_elbow=a+", "'left_elbow=a\\+', not POINT=NAME"),
        ("left_elbow=a,left_elbow=b", "has left_elbow twice; join all its markers with +"),
        ("gone.toml", "map names gone.toml: no such file; check the path"),
    ],
)
def test_bad_mappings_say_what_is_wrong(mapping: str, message: str) -> None:
    with pytest.raises(BadOptionError, match=message):
        parse_mapping(mapping)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("left_elbow = 3", "left_elbow is '3'; expected a name or names"),
        ("left_elbow = []", "expected a name or names"),
        ("left_elbow = ''", "expected a name or names"),
        ("left_elbow = 'a+'", "expected a name or names"),
        ("left_elbow", "is not a TOML file"),
        ("\udcff", "is not a TOML file: it is not text in UTF-8$"),
    ],
)
def test_bad_toml_files_say_what_is_wrong(tmp_path: Path, content: str, message: str) -> None:
    path = tmp_path / "mapping.toml"
    path.write_bytes(content.encode(errors="surrogateescape"))
    with pytest.raises(BadOptionError, match=message) as caught:
        parse_mapping(str(path))
    assert "\n" not in str(caught.value)


def test_a_partial_mapping_goes_before_what_is_recognised() -> None:
    names = KNOWN["Plug-in Gait"][0].split()
    groups = choose_markers(FILE, names, parse_mapping("left_wrist=LFIN,pelvis=LASI+RASI"))
    assert groups["left_wrist"] == ("LFIN",)
    assert groups["right_wrist"] == ("RWRA", "RWRB")
    assert groups["pelvis"] == ("LASI", "RASI")


def test_a_mapping_need_not_spell_names_as_the_file_does() -> None:
    names = ["Anna:" + name for name in ODD]
    groups = choose_markers(FILE, names, parse_mapping(WHOLE.upper().lower()))
    assert groups["left_shoulder"] == ("Anna:ac",)


def test_a_name_that_the_file_has_not_is_reported() -> None:
    with pytest.raises(
        MotionFileError, match=r"has no point olecranon; it has .*; correct the name in map$"
    ):
        choose_markers(FILE, ODD, {"left_elbow": ("olecranon",)})


def test_a_name_that_two_dancers_have_is_reported() -> None:
    names = [f"{dancer}:{name}" for dancer in ("Anna", "Ben") for name in ODD]
    with pytest.raises(MotionFileError, match=r"has two points ac; it has .* in map$"):
        choose_markers(FILE, names, parse_mapping(WHOLE))


def two_dancers() -> list[str]:
    return [f"{dancer}:{name}" for dancer in ("Anna", "Ben") for name in _PLUG_IN_GAIT.split()]


def test_of_two_dancers_one_has_to_be_chosen_and_the_message_tells_how() -> None:
    with pytest.raises(MotionFileError, match="shows 2 people; choose one with") as caught:
        choose_markers(FILE, two_dancers(), {})
    assert "\n" not in str(caught.value)
    options = re.findall(r'map="([^"]*)"', str(caught.value))
    chosen = [choose_markers(FILE, two_dancers(), parse_mapping(option)) for option in options]
    assert [groups["left_elbow"] for groups in chosen] == [("Anna:LELB",), ("Ben:LELB",)]


@pytest.mark.parametrize("dancer", ["Anna", "Ben"])
def test_the_torso_is_that_of_the_dancer_who_is_chosen(dancer: str) -> None:
    known = groups_of(KNOWN["Plug-in Gait"][1])
    mapping = {p: tuple(f"{dancer}:{name}" for name in group) for p, group in known.items()}
    groups = choose_markers(FILE, two_dancers(), mapping)
    named = {name.partition(":")[0] for group in groups.values() for name in group}
    assert named == {dancer}
    assert "pelvis" in groups


def test_a_needed_name_that_stands_twice_is_refused() -> None:
    names = [*KNOWN["Plug-in Gait"][0].split(), "LELB"]
    with pytest.raises(MotionFileError, match="LELB appears twice"):
        choose_markers(FILE, names, {})


def test_a_name_that_stands_for_two_is_refused_as_such() -> None:
    names = KNOWN["Qualisys"][0].replace("Ulna_L", "Radius_L").split()
    with pytest.raises(MotionFileError, match="Radius_L appears twice"):
        choose_markers(FILE, names, {})


def test_other_names_may_stand_twice() -> None:
    names = KNOWN["Plug-in Gait"][0].split()
    assert choose_markers(FILE, [*names, "LKNE"], {}) == choose_markers(FILE, names, {})


def test_one_arm_alone_is_refused() -> None:
    with pytest.raises(MotionFileError, match="has no left arm, and both arms are needed; it has"):
        choose_markers(FILE, ["RSHO", "RELB", "RWRA", "RWRB", "C7"], {})


def test_an_arm_whose_names_say_nothing_can_be_given() -> None:
    names = ["RSHO", "RELB", "RWRI", "M1", "M2", "M3"]
    with pytest.raises(MotionFileError, match="has no left arm") as caught:
        choose_markers(FILE, names, {})
    (option,) = re.findall(r'map="([^"]*)"', str(caught.value))
    for name in names[3:]:
        option = option.replace("?", name, 1)
    groups = choose_markers(FILE, names, parse_mapping(option))
    shown = [group[0] for group in arms(groups).values()]
    assert shown == ["M1", "M2", "M3", "RSHO", "RELB", "RWRI"]


@pytest.mark.parametrize(
    "spelling", ["{}_epicondyle", "{}Epicondyle", "Epicondyle{}", "epicondyle.{}", "{}EPIC"]
)
def test_sides_are_guessed_however_they_are_spelled(spelling: str) -> None:
    names = [spelling.format(side) for side in "LR"]
    with pytest.raises(MotionFileError) as caught:
        choose_markers(FILE, names, {})
    assert f"left_elbow={names[0]}," in str(caught.value)
    assert f"right_elbow={names[1]}," in str(caught.value)


def test_one_arm_without_a_side_is_refused() -> None:
    with pytest.raises(MotionFileError, match="shows a single arm, named neither left"):
        choose_markers(FILE, ["ACRO_tip", "EPICl", "EPICm", "STYLr", "STYLu"], {})


@pytest.mark.parametrize("kind", ["Plug-in Gait", "CMU BVH", "Poser", "MediaPipe", "Xsens"])
@pytest.mark.parametrize("lost", ARM_POINTS)
def test_the_message_offers_a_mapping_that_works_when_filled_in(kind: str, lost: str) -> None:
    text, expected = KNOWN[kind]
    known = groups_of(expected)
    names = [f"m{name[::-1].lower()}x" if name in known[lost] else name for name in text.split()]
    renamed = [name for name in names if name not in text.split()]
    with pytest.raises(MotionFileError) as caught:
        choose_markers(FILE, names, {})
    message = str(caught.value)
    assert "\n" not in message
    assert f"no point is recognised as the {lost.replace('_', ' ')}" in message
    assert all(name in message for name in names)
    (option,) = re.findall(r'name the points with map="([^"]*)"', message)
    filled = re.sub(rf"{lost}=[^,]*", f"{lost}={'+'.join(renamed)}", option)
    groups = choose_markers(FILE, names, parse_mapping(filled))
    assert arms(groups) == known | {lost: tuple(renamed)}


def test_names_without_any_sense_are_listed_with_a_mapping_to_fill_in() -> None:
    names = ["M1", "M2", "M3", "M4", "M5", "M6"]
    with pytest.raises(MotionFileError) as caught:
        choose_markers(FILE, names, {})
    message = str(caught.value)
    assert "it has M1, M2, M3, M4, M5, M6" in message
    (option,) = re.findall(r'map="([^"]*)"', message)
    assert option.count("?") == 6
    for name in names:
        option = option.replace("?", name, 1)
    assert [*choose_markers(FILE, names, parse_mapping(option)).values()] == [(n,) for n in names]


def test_guesses_are_of_the_right_side() -> None:
    names = [f"{part} {side}" for part in ("shoul", "elbo", "handle") for side in ("links", "left")]
    names += ["my_left_acromium", "my_right_acromium", "olecr", "L_styloid", "R_styloid"]
    with pytest.raises(MotionFileError) as caught:
        choose_markers(FILE, names, {})
    message = str(caught.value)
    assert "left_shoulder=my_left_acromium," in message
    assert "right_wrist=R_styloid" in message


def test_hundreds_of_names_are_not_all_listed() -> None:
    with pytest.raises(MotionFileError, match="and 180 more"):
        choose_markers(FILE, [f"M{i}" for i in range(300)], {})


@pytest.mark.parametrize("kind", ["Plug-in Gait", "CMU", "Xsens", "Kinect"])
def test_a_subject_at_the_end_of_the_names_does_not_matter(kind: str) -> None:
    names, expected = KNOWN[kind]
    groups = choose_markers(FILE, [f"{name}_anna" for name in names.split()], {})
    known = groups_of(expected)
    assert arms(groups) == {p: tuple(f"{n}_anna" for n in group) for p, group in known.items()}


@pytest.mark.parametrize("spelling", ["{1}{0}", "{0}{1}", "{1}_{0}"])
def test_two_dancers_are_told_apart_by_names_that_are_glued_on(spelling: str) -> None:
    names = [spelling.format(n, d) for d in ("Anna", "Ben") for n in _PLUG_IN_GAIT.split()]
    with pytest.raises(MotionFileError, match="shows 2 people; choose one with") as caught:
        choose_markers(FILE, names, {})
    options = re.findall(r'map="([^"]*)"', str(caught.value))
    chosen = [choose_markers(FILE, names, parse_mapping(option)) for option in options]
    for groups, dancer in zip(chosen, ("Anna", "Ben"), strict=True):
        assert all(dancer in name for group in groups.values() for name in group)
        assert len(groups["pelvis"]) == 4


def test_ends_of_bones_and_angles_of_joints_are_no_joints() -> None:
    bones = ("LeftArm", "LeftForeArm", "LeftHand", "RightArm", "RightForeArm", "RightHand")
    joints = ("LShoulder", "LElbow", "LWrist", "RShoulder", "RElbow", "RWrist")
    for names in ([f"{bone}_end" for bone in bones], [f"{joint}Angles" for joint in joints]):
        with pytest.raises(MotionFileError, match="no point is recognised") as caught:
            choose_markers(FILE, names, {})
        assert mapping_in(str(caught.value)) == {point: ("?",) for point in ARM_POINTS}


def mapping_in(message: str) -> Groups:
    (option,) = re.findall(r'map="([^"]*)"', message)
    return parse_mapping(option)


@pytest.mark.parametrize(
    ("names", "left"),
    [
        # "elbowright" contains the beginning of a wrist
        ("ShoulderLeft ElbowLeft ShoulderRight ElbowRight", "ShoulderLeft ElbowLeft ?"),
        # of OpenSim's two bones of the forearm, neither is the wrist
        ("humerus_l ulna_l radius_l humerus_r ulna_r radius_r", "humerus_l ulna_l ?"),
        # markers on segments are no joints
        ("LSHO LUARM LFARM LWRA LWRB RSHO RUARM RFARM RWRA RWRB", "LSHO ? LWRA+LWRB"),
        ("LUPA LARM LELB LFRM LFOREARM RUPA RARM RELB RFRM RFOREARM", "? LELB ?"),
        # collar bones are no shoulders
        ("LCollar LElbow LWrist RCollar RElbow RWrist", "? LElbow LWrist"),
        ("LCLAV LELB LWRI RCLAV RELB RWRI SACR", "? LELB LWRI"),
        (
            "LeftShoulder LeftForeArm LeftHand RightShoulder RightForeArm RightHand",
            "? ?",
        ),
        ("LShoulder LForeArm LWrist RShoulder RForeArm RWrist", "? ? LWrist"),
        # one of two markers is beside the joint
        ("LSHO LMELBO LLELBO LWRI RSHO RMELBO RLELBO RWRI", "LSHO LMELBO+LLELBO LWRI"),
        ("LSho LElb1 LElb2 LWri1 LWri2 RSho RElb1 RElb2 RWri1 RWri2", "LSho ? ?"),
        # joint angles are no places
        (
            "L_shoulder_pitch L_elbow_yaw L_wrist R_shoulder_pitch R_elbow_yaw R_wrist",
            "? ? L_wrist",
        ),
        # three look like it
        ("LSHO LELB LWR1 LWR2 LWR3 RSHO RELB RWR1 RWR2 RWR3", "LSHO LELB ?"),
        ("LSHO LELB1 LELB2 LWRI RSHO RELB1 RELB2 RWRI", "LSHO ? LWRI"),
    ],
)
def test_the_mapping_in_a_refusal_is_right_or_holds_a_question_mark(names: str, left: str) -> None:
    with pytest.raises(MotionFileError) as caught:
        choose_markers(FILE, names.split(), {})
    groups = mapping_in(str(caught.value))
    for side in "lr":
        shown = ["+".join(g) for p, g in groups.items() if p.startswith(side)]
        swap = {"L": "R", "_l": "_r", "Left": "Right"}
        expected = left.split()
        if side == "r":
            for one, other in sorted(swap.items(), key=lambda pair: -len(pair[0])):
                expected = [
                    name.replace(one, other) if len(one) > 1 else re.sub(r"\bL(?!eft)", "R", name)
                    for name in expected
                ]
        assert shown[: len(expected)] == expected


def test_names_that_look_like_arms_are_listed_first() -> None:
    others = [f"m{i}" for i in range(150)]
    with pytest.raises(MotionFileError, match="it has LSHO, LELB, RSHO, RELB, m0, m1"):
        choose_markers(FILE, [*others, "LSHO", "LELB", "RSHO", "RELB"], {})


def test_a_hand_in_place_of_a_wrist_is_noted() -> None:
    report = ImportReport()
    choose_markers(FILE, KNOWN["NITE, without wrists"][0].split(), {}, report)
    assert report.steps == [
        f"Hand{side} stands for a wrist, which the file does not name" for side in ("Left", "Right")
    ]
    for kind in KNOWN.keys() - {"NITE, without wrists"}:
        report = ImportReport()
        choose_markers(FILE, KNOWN[kind][0].split(), {}, report)
        assert not report.steps, kind


def test_names_may_be_numbers() -> None:
    points = zip(ARM_POINTS, "123456", strict=True)
    groups = parse_mapping(",".join(f"{point}={number}" for point, number in points))
    assert choose_markers(FILE, list("123456789"), groups) == groups


@pytest.mark.parametrize("names", [[], [""], ["_", ":", "  "], ["x" * 1_000_000], ["L" * 50_000]])
def test_odd_names_are_refused_in_one_line(names: list[str]) -> None:
    match = "no point is recognised as the left shoulder"
    with pytest.raises(MotionFileError, match=match) as caught:
        choose_markers(FILE, names, {})
    assert len(str(caught.value)) < 500
