"""The report of a run: figures and numbers from the recordings of one robot or a team."""
