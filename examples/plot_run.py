"""Plot who is responsible, and one segment's direction, from a run's trace.

python examples/plot_run.py
"""

import matplotlib
import numpy as np

import mpma_mj

matplotlib.use("Agg")
import matplotlib.pyplot as plt

folder = mpma_mj.imitate("ymca", seed=0).save("runs/plot", overwrite=True)
trace = np.load(folder / "trace.npz")
time = np.arange(len(trace["responsibility"])) / 20.0  # 20 control steps a second

figure, (upper, lower) = plt.subplots(2, 1, sharex=True, figsize=(8, 5))
upper.plot(time, trace["responsibility"])  # (T, M)
upper.set_ylabel("responsibility")
lower.plot(time, trace["reference"][:-1, :3], "k--", linewidth=0.8)
lower.plot(time, trace["posture"][:-1, :3])
lower.set(xlabel="time, s", ylabel="left upper arm")
figure.savefig("plot.png", dpi=120)
print("plot.png")
