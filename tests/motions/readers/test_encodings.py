"""Encodings are told by the bytes of a file."""

import pytest

from mpma_mj.motions.readers.encodings import encoding_of

JAPANESE = "time,左腕_x,左ひじ_x,左手首_x,右腕_x,センター_x,首_x"


@pytest.mark.parametrize("encoding", ["utf-8", "cp932", "utf-8-sig", "utf-16"])
def test_japanese_is_read_in_its_encodings(encoding: str) -> None:
    for end in range(0, 3):  # which may cut a letter
        head = (JAPANESE + "腕").encode(encoding)[: -end or None]
        assert encoding_of(head) == encoding


@pytest.mark.parametrize(
    "text",
    ["Épaule gauche X;Coude gauche X", "Hände_x,Hüfte_x", "º±ß", "muñeca", "l’épaule d’Anna"],
)
def test_latin_script_is_no_japanese(text: str) -> None:
    assert encoding_of(text.encode("cp1252")) == "latin-1"
    assert encoding_of(text.encode()) == "utf-8"


def test_what_has_zeros_is_no_text() -> None:
    assert encoding_of(b"a\0b") is None
