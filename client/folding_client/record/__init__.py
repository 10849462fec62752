"""The record of a run: one folder that is complete up to the last event, whatever ends the run."""
