"""Titles of columns, arrays and values: the axis, time, rate, frame, person or point meant."""

from __future__ import annotations

import re
import unicodedata

from mpma_mj.motions.readers.recording import UNITS

__all__ = [
    "RATE",
    "is_frame",
    "is_no_place",
    "is_person",
    "is_point",
    "is_rate",
    "is_time",
    "length_unit",
    "may_be_time",
    "split_axis",
    "time_unit",
]

RATE = (
    r"((export|capture|frame|data|camera|sample|sampling|video|mocap|acquisition|marker)s?[\s_]*)*"
    r"(rate|frequency|freq|fps|per[\s_]second)[\s_]*([(\[]?(hz|fps)[)\]]?)?"
)
"""Pattern of titles of a rate, whatever their case."""

_BRACKETED = r"\s*[(\[]\s*[\w.°/²^]+\s*[)\]]"
# left_wrist_x, LWRI.X, LWristX, X1, "left wrist x (mm)", left_wrist_x_mm
_AXIS_LAST = re.compile(
    rf"(?P<name>.*?)[\s_.:\-(\[]*(?P<axis>[xyzXYZ])\d*[)\]]?"
    rf"(?:{_BRACKETED}|[\s_]+([mc]?m|world|global|px|pixels?))?\s*$"
)
# x_left_wrist, "X position"
_AXIS_FIRST = re.compile(r"(?P<axis>[xyzXYZ])[\s_.:\-]+(?P<name>.*)")
_PLACE = re.compile(
    r"(?<![^\W_])(?<![xyz][\s_])[pt](?=[xyz](?![^\W_]))", re.IGNORECASE
)  # left_wrist_px, tx
_OF_AN_AXIS = {"", "axis", "position", "pos", "coord", "coordinate", "coordinates", "location"}

_TIMES = {
    *("t", "ts", "time", "times", "timestamp", "timestamps", "timecode", "datetime", "seconds"),
    *("secs", "zeit", "zeitstempel", "uhrzeit", "temps", "horodatage", "tiempo", "tempo", "hora"),
    *("tijd", "tijdstip", "czas", "aika", "zaman", "время", "時間", "时间"),
}
_PERHAPS_TIMES = {
    "stamp",
    "clock",
    "elapsed",
    "date",
    "datum",
    "datenum",
    "fecha",
    "epoch",
    "utc",
    "unix",
}
_OF_TIME = {
    *("elapsed", "capture", "frame", "recording", "record", "sample", "video", "unix", "epoch"),
    *("system", "device", "sensor", "host", "ros", "relative", "rel", "utc", "local", "stamp"),
    *("in", "of", "since", "start", "begin", "date", "iso", "real", "wall", "clock", "mocap"),
    *("datum", "fecha"),
}
_SECONDS = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), 1.0),
    **dict.fromkeys(("ms", "msec", "msecs", "millis", "millisecond", "milliseconds"), 1e-3),
    **dict.fromkeys(("us", "µs", "usec", "micros", "microseconds"), 1e-6),
    **dict.fromkeys(("ns", "nsec", "nanos", "nanoseconds"), 1e-9),
    **dict.fromkeys(("sekunden", "secondes", "segundos", "secondi", "seconden", "sek"), 1.0),
    **dict.fromkeys(("millisekunden", "millisecondes", "milisegundos", "millisecondi"), 1e-3),
    **dict.fromkeys(("min", "mins", "minute", "minutes", "minuten", "minutos", "minuti"), 60.0),
    **dict.fromkeys(("h", "hr", "hrs", "hour", "hours", "stunden", "heures", "horas"), 3600.0),
    **dict.fromkeys(("d", "day", "days", "tage", "jours", "dias"), 86400.0),
}
_NOT_ALONE = {"s", "min", "mins", "h", "hr", "d", "day", "days"}  # "min" is a minimum
_FRAMES = {
    *("frame", "frames", "index", "field", "framenumber", "framenum", "frameno", "framenr"),
    *("fnum", "frameindex", "frameidx", "frameid", "fieldnumber", "fieldno", "samplenumber"),
}
_PEOPLE = re.compile(
    "(person|people|subject|body|skeleton|track|player|user|actor|performer|human|dancer|instance"
    "|participant|individual|take|trial|session|sequence|clip|video|file)s?(id|idx|index|no|nr|num"
    "|number|name|label)?|(tracking|pose|object|target|character)(id|index|number|name)"
    "|id|ids|pid|uid|who|name"
)
_POINTS = re.compile(
    "(keypoint|joint|marker|landmark|bodypart|bodypoint|bone|segment|point|node|sensor|keypt|kp|part"
    "|label|feature|trajectory|gelenk|punkt|knochen|articulation|articulacion|articolazione|giunto"
    "|gewricht|punto)s?(id|ids|idx|index|no|nr|num|number|name|label|type)?|name|(child)?frameid"
)
# Of a point, but not where it is: "x (m/s)", left_wrist_velocity_x, transform.rotation.x, x_px
_NO_PLACE = re.compile(
    r"/\s*s|[(\[]\s*(deg|rad|°)|^(deg|rad|°)$|(?<![a-z])(degrees|radians)(?![a-z])"
    r"|[xyz][\s_(\[]+(px|pixels?)(?![a-z])"
    r"|(?<![a-z])(rot|rotation|quat|quaternion|orientation|euler|vel|velocity|speed|accel"
    r"|acceleration)(?![a-z])",
    re.IGNORECASE,
)
_LENGTHS = {
    **{"m": "m", "meter": "m", "meters": "m", "metres": "m"},
    **{"cm": "cm", "centimeters": "cm", "mm": "mm", "millimeters": "mm", "inches": "inch"},
    **{"metre": "m", "centimetres": "cm", "millimetres": "mm", "inch": "inch", "in": "inch"},
    **dict.fromkeys(("ft", "feet", "foot"), "ft"),
}


def is_no_place(title: str) -> bool:
    """Return whether a cell is that of rotations, speeds or pixels, and not of places."""
    return _NO_PLACE.search(title) is not None


def split_axis(title: str) -> tuple[str, str]:
    """Return the name of a point and "x", "y" or "z" from a title; twice "" for another one.

    The name is "" where the title is the axis alone.
    """
    title = _PLACE.sub("", title)
    found = _AXIS_LAST.fullmatch(title)
    if found and not _ends_word(title, found):
        digits = re.fullmatch(r"[xyzXYZ][\W_]*(\d+)\W*", title)  # of a point, or TRC's
        return (digits[1] if digits else found["name"]), found["axis"].lower()
    found = _AXIS_FIRST.fullmatch(title)
    if found is None:
        return "", ""
    name = found["name"].strip(" _.:-")
    return ("" if name.lower() in _OF_AN_AXIS else name), found["axis"].lower()


def _ends_word(title: str, found: re.Match[str]) -> bool:
    """Return whether the axis is the end of a word, as in "index", and not set off: LWristX."""
    axis = found.start("axis")
    return (
        axis > 0
        and title[axis - 1].isalpha()
        and not (title[axis].isupper() and title[axis - 1].islower())
    )


def is_frame(title: str) -> bool:
    """Return whether a column holds numbers of frames."""
    return _letters(title) in _FRAMES


def is_time(title: str) -> bool:
    """Return whether a column holds times."""
    words = set(_words(title))
    units = (words & _SECONDS.keys()) - _NOT_ALONE
    return bool(words & _TIMES or units) and words <= _TIMES | _OF_TIME | _SECONDS.keys()


def may_be_time(title: str) -> bool:
    """Return whether a column holds times if no other does, as one of dates may."""
    words = set(_words(title))
    return bool(words & _PERHAPS_TIMES) and words <= _OF_TIME | _PERHAPS_TIMES | _SECONDS.keys()


def time_unit(title: str) -> float | None:
    """Return the unit of times that a title names, s."""
    return next((_SECONDS[word] for word in _words(title) if word in _SECONDS), None)


def is_rate(title: str) -> bool:
    """Return whether a title is that of a rate, Hz."""
    return re.fullmatch(RATE, title, re.IGNORECASE) is not None


def is_person(title: str) -> bool:
    """Return whether a column distinguishes people, or takes."""
    return _PEOPLE.fullmatch(_letters(title)) is not None


def is_point(title: str) -> bool:
    """Return whether a column names points."""
    return _POINTS.fullmatch(_letters(title)) is not None


def length_unit(cell: str) -> float | None:
    """Return the length of a unit that a cell names, alone or after the axis, m."""
    found = re.search(r"[(\[]\s*(\w+)\s*[)\]]$|(?<=[\s_])[mc]?m$", cell)
    name = _LENGTHS.get((found[1] or found[0] if found else cell).lower())
    return None if name is None else UNITS[name]


def _letters(title: str) -> str:
    return re.sub(r"[\W_]", "", title.lower())


def _words(title: str) -> list[str]:
    """Return the words of a title in lower case without accents, set off by signs or capitals."""
    parted = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", title)
    plain = "".join(c for c in unicodedata.normalize("NFD", parted) if not unicodedata.combining(c))
    return re.findall(r"[^\W_\d]+", plain.lower())
