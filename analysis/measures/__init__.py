"""Figures of merit: functions of what a log holds, which draw nothing."""
