"""The report of a run: figures and numbers out of the recordings of one robot or a team."""
