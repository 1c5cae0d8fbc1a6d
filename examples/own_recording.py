"""Imitate a recording: here a table of points that this script writes itself.

python examples/own_recording.py
"""

import numpy as np

import mpma_mj

# Ten seconds at 100 Hz of somebody who raises both arms and lowers them again, in m, z up.
time = np.arange(0, 10, 0.01)
lift = 0.5 - 0.5 * np.cos(2 * np.pi * time / 2.5)  # 0 where the arms hang, 1 where they are level
columns = {"time_s": time}
for side, sign in (("left", 1.0), ("right", -1.0)):
    angle = 0.2 + 1.2 * lift
    direction = np.stack([0.3 * lift, sign * np.sin(angle), -np.cos(angle)], axis=1)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    shoulder = np.tile([0.0, 0.2 * sign, 1.4], (len(time), 1))
    points = {
        "shoulder": shoulder,
        "elbow": shoulder + 0.30 * direction,
        "wrist": shoulder + 0.55 * direction,
    }
    for name, point in points.items():
        columns |= {f"{side}_{name}_{axis}": point[:, i] for i, axis in enumerate("xyz")}
header = ",".join(columns)
np.savetxt(
    "lifts.csv", np.stack([*columns.values()], axis=1), header=header, comments="", delimiter=","
)

motion = mpma_mj.read_motion("lifts.csv", up="z")  # the file does not say which axis is up
print(motion)
run = mpma_mj.imitate(motion, epochs=4)
print(f"p_e {run.summary['p_e_percent']:.2f} %")
