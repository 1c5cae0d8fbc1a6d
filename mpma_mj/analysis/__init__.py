"""What the modules of a trained run do, as pure functions of its signals."""
