"""Pages of reports that are quick to make: drawing every signature takes long."""

from dataclasses import replace

from analysis.report.material import Material


def narrowed(material: Material, shown: tuple[str, ...]) -> Material:
    """Return the same with the signatures alone whose columns begin so."""
    analysis = material.analysis
    keys = [name for name in analysis.runs if "." not in name or name.startswith(shown)]
    estimates = {key: estimate for key, estimate in analysis.compared.estimates.items() if key[0].startswith(shown)}
    compared = replace(analysis.compared, estimates=estimates)
    contrasts = analysis.contrasts[analysis.contrasts["measure"].str.startswith(shown)]
    table = replace(analysis.table, frame=analysis.runs[keys])
    return replace(material, analysis=replace(analysis, table=table, compared=compared, contrasts=contrasts))
