"""Analyses runs of any form by the keys that all forms share.

Keys that only one form has are analysed by the code in the folder of this form, such as `analysis/grid`.
"""

from analysis.any.any_records import read_records, schema
from analysis.any.any_run import AnyRun
from analysis.form import ANY, FormAnalysis

ANALYSIS = FormAnalysis(name=ANY, run=AnyRun, read=read_records, schema=schema)
