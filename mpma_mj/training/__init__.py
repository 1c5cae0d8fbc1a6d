"""Training: epochs, run folders, figures and videos."""
