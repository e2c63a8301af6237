"""Analysis of runs of any form, from the keys that all steps have. The folder of a form analyses its other keys."""

from analysis.any.any_records import read_records, schema
from analysis.any.any_run import AnyRun
from analysis.form import ANY, FormAnalysis

ANALYSIS = FormAnalysis(name=ANY, run=AnyRun, read=read_records, schema=schema)
