"""The forced impact oscillator: model, reset laws, free flight, sign windows, contact rule, trajectory."""
