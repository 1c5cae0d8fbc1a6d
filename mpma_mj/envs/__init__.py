"""Environments in which two arms imitate a motion: dm_env, Gymnasium, vectors, wrappers."""
