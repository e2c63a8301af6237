"""Computes means and intervals of independent values, one per seed."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from analysis.arrays import FloatArray
from analysis.stats.sign_flip import sign_flip_interval
from analysis.stats.values import BoolArray
from foundry.seeding import stream

LEVEL = 0.95
FEWEST_FOR_CLAIMS = 6
"""Minimum number of values for a test; with fewer, no exact test can reach p < .05."""
ENOUGH_FOR_CLAIMS = 20
"""Recommended number of values for claims; with fewer, only large differences become significant."""
FEWEST_FOR_BOOTSTRAP = 10
SKEWED = 0.5
"""Absolute skewness above which the bootstrap-t widens Student's interval."""
RESAMPLES = 1_999
STUDENT, BOOTSTRAP_T, WILSON, SIGN_FLIP, NO_INTERVAL = "t", "bootstrap-t", "wilson", "sign-flip", ""
NO_VALUE, ONE_VALUE, NO_VARIATION = "no value", "one value", "no variation"
FEW = f"descriptive (n < {FEWEST_FOR_CLAIMS})"
_ROWS_AT_ONCE = 256
"""Number of rows whose resamples are in memory at once."""
_STUDENT_95 = (
    12.706204736174694, 4.302652729749462, 3.1824463052837078, 2.7764451051977934, 2.5705818356363146,
    2.4469118511449786, 2.364624251592784, 2.306004135204166, 2.262157162798205, 2.228138851986274, 2.200985160091639,
    2.1788128296672284, 2.1603686564627913, 2.144786687917804, 2.131449545559776, 2.1199052992212546,
    2.1098155778333156, 2.1009220402410382, 2.0930240544083087, 2.085963447265864, 2.0796138447276795,
    2.0738730679040254, 2.0686576104190486, 2.0638985616280245, 2.0595385527532972, 2.0555294386428735,
    2.0518305164802846, 2.0484071417952454, 2.045229642132703, 2.0422724563012378, 2.039513446396408,
    2.0369333434601016, 2.0345152974493383, 2.0322445093177186, 2.030107928250343, 2.0280940009804502,
    2.0261924630291093, 2.0243941639119694, 2.022690920036761, 2.021075390306273,
)  # fmt: skip
"""Two-sided quantiles of Student's t at LEVEL, for 1, 2, ... degrees of freedom.

The quantiles are listed here because importing `scipy.special` to compute them takes long.
"""
_NORMAL_95 = 1.959963984540054
"""The two-sided quantile of the normal distribution at LEVEL."""
_ROUNDING = 1e-12
"""Values count as equal if they differ by less than _ROUNDING times the largest value."""


@dataclass(frozen=True)
class Estimate:
    """A mean and its interval.

    Attributes:
        mean: NaN without values.
        sd: standard deviation, ddof 1; NaN with fewer than two values.
        low: lower end of the interval; NaN if undefined.
        interval: STUDENT, BOOTSTRAP_T, WILSON, SIGN_FLIP or NO_INTERVAL.
        note: the reason why there is no interval, or why it only describes the runs, or "".
    """

    n: int
    mean: float
    sd: float
    low: float
    high: float
    interval: str
    note: str


@dataclass(frozen=True)
class Estimates:
    """Means and intervals of many rows of values; each attribute of `Estimate` is an array (rows,)."""

    n: npt.NDArray[np.int64]
    mean: FloatArray
    sd: FloatArray
    low: FloatArray
    high: FloatArray
    interval: npt.NDArray[np.object_]
    note: npt.NDArray[np.object_]

    @classmethod
    def joined(cls, parts: "Sequence[Estimates]") -> "Estimates":
        """Return one object that contains the rows of all given objects, in order."""
        return cls(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(cls)))

    def row(self, index: int) -> Estimate:
        """Return the estimate of one row."""
        return Estimate(*(getattr(self, field.name)[index : index + 1].tolist()[0] for field in fields(self)))


def estimate(
    values: FloatArray,
    low: float = -math.inf,
    high: float = math.inf,
    *,
    beside_sign_flips: bool = False,
    level: float = LEVEL,
) -> Estimate:
    """Return the mean of values (n,) and its interval; see `estimates`."""
    ends = np.array([low]), np.array([high])
    return estimates(values[None, :], *ends, beside_sign_flips=beside_sign_flips, level=level).row(0)


def estimates(
    values: FloatArray,
    low: FloatArray,
    high: FloatArray,
    binary: BoolArray | None = None,
    *,
    beside_sign_flips: bool = False,
    level: float = LEVEL,
) -> Estimates:
    """Return the mean of each row with its interval, by default of 95 %.

    The interval is Student's t, mean -+ t(n-1) sd / sqrt(n). If the values are skewed and at least
    FEWEST_FOR_BOOTSTRAP, the bootstrap-t can widen it. Outcomes that are 0 or 1 have Wilson's interval.

    Args:
        values: independent values (rows, n); NaN are left out.
        low: least possible values (rows,); intervals are clipped to them.
        high: greatest possible values.
        binary: which rows hold outcomes of 0 or 1 (rows,); none by default.
        beside_sign_flips: whether the sign-flip test tests these values. Then FEWEST_FOR_CLAIMS or more values have the
            interval of the shifts that this test does not reject, so that interval and test agree.
        level: level of the intervals; 1 - 2 alpha matches a one-sided test at alpha.
    """
    rows = len(values)
    mean, sd, lower, upper = (np.full(rows, np.nan) for _ in range(4))
    count = (~np.isnan(values)).sum(axis=1)
    filled = Estimates(count, mean, sd, lower, upper, _texts(rows, NO_INTERVAL), _texts(rows, NO_VALUE))
    for chosen, present in by_count(values):
        filled.mean[chosen] = present.mean(axis=1)
        filled.note[chosen] = ONE_VALUE
        if present.shape[1] > 1:
            outcome = np.zeros(len(chosen), dtype=bool) if binary is None else binary[chosen]
            _fill(filled, chosen, present, outcome, beside_sign_flips, level)
    np.copyto(filled.low, np.maximum(filled.low, low))
    np.copyto(filled.high, np.minimum(filled.high, high))
    return filled


def by_count(values: FloatArray) -> Iterator[tuple[npt.NDArray[np.intp], FloatArray]]:
    """For each n >= 1, yield the indices of the rows with n values (k,), and these values without NaN (k, n)."""
    defined = ~np.isnan(values)
    counts = defined.sum(axis=1)
    for n in np.unique(counts[counts > 0]):
        chosen = np.flatnonzero(counts == n)
        present = values[chosen]
        whole = n == values.shape[1]
        yield chosen, np.ascontiguousarray(present) if whole else present[defined[chosen]].reshape(len(chosen), n)


def varies(values: FloatArray) -> BoolArray:
    """Return which rows (rows, n) contain different values, apart from rounding."""
    least, most = values.min(axis=1), values.max(axis=1)
    return np.asarray(most - least > _ROUNDING * np.maximum(np.maximum(most, -least), 1.0))


def skewness(values: FloatArray) -> FloatArray:
    """Return the moment skewness m3 / m2^1.5 of each row (rows, n); the rows must vary."""
    centred = values - values.mean(axis=1, keepdims=True)
    return np.asarray((centred**3).mean(axis=1) / (centred**2).mean(axis=1) ** 1.5)


def student_quantile(freedom: int, level: float = LEVEL) -> float:
    """Return the two-sided quantile of Student's t."""
    if level == LEVEL and freedom <= len(_STUDENT_95):
        return _STUDENT_95[freedom - 1]
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.5 + level / 2))


def wilson(rate: FloatArray, n: int, level: float = LEVEL) -> tuple[FloatArray, FloatArray]:
    """Return Wilson's interval of rates (rows,) among n outcomes: lower and upper ends (Wilson 1927)."""
    z2 = normal_quantile(level) ** 2
    centre = (rate + z2 / (2 * n)) / (1 + z2 / n)
    half = np.sqrt(z2 * (rate * (1 - rate) / n + z2 / (4 * n * n))) / (1 + z2 / n)
    return centre - half, centre + half


def normal_quantile(level: float = LEVEL) -> float:
    """Return the two-sided quantile of the normal distribution."""
    if level == LEVEL:
        return _NORMAL_95
    from scipy.special import ndtri

    return float(ndtri(0.5 + level / 2))


def bootstrap_t(values: FloatArray, level: float = LEVEL) -> tuple[FloatArray, FloatArray]:
    """Return the bootstrap-t interval of each row's mean (rows, n): lower and upper ends (Efron 1981).

    The resamples depend on n alone and are the same for every row. An end is infinite if too many resamples have no
    variation.
    """
    n = values.shape[1]
    mean, sd = values.mean(axis=1, keepdims=True), values.std(axis=1, ddof=1, keepdims=True)
    scaled = (values - mean) / sd
    ends = np.concatenate([_ends_of_t(part, level) for part in _parts(scaled)] or [np.zeros((0, 2))])
    half = (sd / math.sqrt(n))[:, 0]
    return mean[:, 0] - ends[:, 1] * half, mean[:, 0] - ends[:, 0] * half


def _parts(rows: npt.NDArray[Any]) -> list[npt.NDArray[Any]]:
    return [rows[start : start + _ROWS_AT_ONCE] for start in range(0, len(rows), _ROWS_AT_ONCE)]


def _ends_of_t(scaled: FloatArray, level: float) -> FloatArray:
    """Return the lower and upper quantiles of t (rows, 2) over resamples of standardised values (rows, n)."""
    n = scaled.shape[1]
    weights = _resamples(n)
    means = scaled @ weights.T / n
    variances = (scaled**2 @ weights.T / n - means**2) * n / (n - 1)
    # A resample of equal values has no t and counts as the most extreme one.
    flat = variances <= _ROUNDING
    t = means * math.sqrt(n) / np.sqrt(np.where(flat, 1.0, variances))
    t = np.where(flat, np.copysign(np.inf, means), t)
    # Order statistics are used, since an infinite t cannot be interpolated.
    last = int((1 - level) / 2 * (RESAMPLES + 1))
    ends = [last - 1, RESAMPLES - last]
    return np.asarray(np.partition(t, ends, axis=1)[:, ends])


@lru_cache(maxsize=4)
def _resamples(n: int) -> FloatArray:
    """Return how often each of n values is drawn in each resample (RESAMPLES, n)."""
    drawing, counts = stream(n, "bootstrap-t"), np.empty((RESAMPLES, n))
    for resample in counts:
        resample[:] = np.bincount(drawing.integers(0, n, size=n), minlength=n)
    counts.flags.writeable = False
    return counts


def _fill(
    filled: Estimates,
    rows: npt.NDArray[np.intp],
    present: FloatArray,
    outcome: BoolArray,
    beside_sign_flips: bool,
    level: float,
) -> None:
    """Compute standard deviation, interval and note of the given rows (k,), from n > 1 values per row, (k, n)."""
    n = present.shape[1]
    few = FEW if n < FEWEST_FOR_CLAIMS else ""
    vary = varies(present)
    filled.sd[rows] = np.where(vary, np.concatenate([part.std(axis=1, ddof=1) for part in _parts(present)]), 0.0)
    filled.note[rows] = np.where(vary | outcome, few, "; ".join(filter(None, (NO_VARIATION, few)))).astype(object)
    if beside_sign_flips and n >= FEWEST_FOR_CLAIMS:
        _set(filled, rows, vary, sign_flip_interval(present, level), SIGN_FLIP)
        return
    half = student_quantile(n - 1, level) * filled.sd[rows] / math.sqrt(n)
    _set(filled, rows, vary & ~outcome, (filled.mean[rows] - half, filled.mean[rows] + half), STUDENT)
    if outcome.any():
        _set(filled, rows[outcome], outcome[outcome], wilson(filled.mean[rows[outcome]], n, level), WILSON)
    if n >= FEWEST_FOR_BOOTSTRAP:
        _use_bootstrap(filled, rows, present, vary & ~outcome, level)


def _use_bootstrap(
    filled: Estimates, rows: npt.NDArray[np.intp], present: FloatArray, vary: BoolArray, level: float
) -> None:
    """Widen the intervals of skewed rows: a row gets the outer ends of Student's interval and of the bootstrap-t.

    The bootstrap-t alone is too narrow if many values are equal.
    """
    able = np.flatnonzero(vary)
    skewed = np.concatenate([part[np.abs(skewness(present[part])) > SKEWED] for part in _parts(able)] or [able])
    ends = [np.array(bootstrap_t(present[part], level)) for part in _parts(skewed)]
    low, high = np.concatenate(ends or [np.zeros((2, 0))], axis=1)
    finite = np.isfinite(low) & np.isfinite(high)
    low, high = np.minimum(low, filled.low[rows[skewed]]), np.maximum(high, filled.high[rows[skewed]])
    _set(filled, rows[skewed], finite, (low, high), BOOTSTRAP_T)


def _set(
    filled: Estimates,
    rows: npt.NDArray[np.intp],
    chosen: BoolArray,
    ends: tuple[FloatArray, FloatArray],
    interval: str,
) -> None:
    filled.low[rows[chosen]], filled.high[rows[chosen]] = ends[0][chosen], ends[1][chosen]
    filled.interval[rows[chosen]] = interval


def _texts(count: int, text: str) -> npt.NDArray[np.object_]:
    return np.full(count, text, dtype=object)
