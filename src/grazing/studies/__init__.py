"""Studies: functions of a map that return a labelled result. No study knows another."""
