"""Modes of a structure from its free decay: frequencies and damping ratios from a ring-down.

A free decay is a sum of damped sines, the same in every direction but for amplitude and phase:

    y(t) = sum_k a_k exp(-sigma_k t) cos(omega_k t + phi_k) + c,   zeta_k = sigma_k / |sigma_k + i omega_k|

The matrix pencil on the singular vectors of the Hankel matrix gives all poles at once (Hua and Sarkar
1990, IEEE Trans. Acoust. Speech Signal Process. 38, 814-824), so that neighbouring modes do not spoil each
other as they do in a logarithmic decrement. Before, the signal is low-passed and thinned by an FIR filter
that lies wholly within the decay: that scales each damped sine and leaves its pole as it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import firwin

from .harmonics import Harmonic, origins
from .windows import LEAST_PERIODS, candidates

Array = NDArray[np.float64]

ORDERS = (3, 5, 7, 9, 11, 13, 15, 17)  # poles: pairs, and one for what does not swing
SAMPLES = 700  # that are looked at, at most
OVERSAMPLED = 6.0  # samples a period of the fastest vibration that counts
SMALL = 0.02  # part of the largest amplitude below which a vibration does not count
EXPLAINED = 0.98  # least share of a decay's power that its modes must account for
GOOD = 0.995  # share from which a decay need not begin later
STABLE = (0.01, 0.25)  # a mode is one where two orders agree so well in frequency, and in damping
MOST_DAMPED = 0.5
ALIKE = 0.25  # a harmonic's rate of decay and that of its origins
AUDIBLE = 5.0  # times the noise in it, the power of a decay
HEARD = 15.0  # times the noise of a sample, the energy of a mode; twice that of noise's highest line
AUDIBLE_LINE = 3.0  # times the middle one, a line of a spectrum that is more than noise
LEAST_SAMPLES = 40
MOST_REASONS = 4  # of the largest


@dataclass(frozen=True)
class Mode:
    """One mode: Hz, damping ratio, amplitude at the decay's beginning in the signal's unit.

    spread : of the damping ratio over parts of the decay and orders of the model; half of its range
    """

    frequency: float
    damping: float
    amplitude: float
    spread: float


@dataclass(frozen=True)
class RingDown:
    """A free decay: from when to when, s, its modes by falling amplitude, and the share that they explain.

    explained : of the power, without that of white noise
    harmonics : damped sines that come from the modes (harmonics.py) and are none
    """

    begin: float
    end: float
    modes: tuple[Mode, ...]
    explained: float
    harmonics: tuple[Harmonic, ...] = ()


def poles(signal: Array, period: float, order: int) -> tuple[NDArray[np.complex128], Array, float]:
    """Fit K samples (K, d) of a free decay.

    Returns
    -------
    exponents (p,), 1/s; amplitudes (p,), of all d directions together; share of the power explained
    """
    samples, directions = signal.shape
    rows = samples // 3
    blocks = [np.lib.stride_tricks.sliding_window_view(signal[:, d], rows).T for d in range(directions)]
    hankel = np.concatenate(blocks, axis=1)
    # The left singular vectors; of the square matrix they are cheaper and as good at these orders.
    _, u = np.linalg.eigh(hankel @ hankel.T)
    u = u[:, ::-1][:, : min(order, rows - 1)]
    roots: NDArray[np.complex128] = np.linalg.eigvals(np.linalg.lstsq(u[:-1], u[1:], rcond=None)[0]).astype(
        complex
    )
    roots = roots[np.abs(roots) > 1e-6]
    # What grows is no decay; a root a little outside of the circle is one of no damping, with noise.
    roots = roots[np.abs(roots) < 1.0 + 2.0 / samples]
    if not len(roots):
        return np.empty(0, np.complex128), np.empty(0), 0.0
    exponents = np.asarray(np.log(roots) / period, dtype=np.complex128)
    parts = np.exp(np.outer(np.arange(samples) * period, exponents))
    weights = np.linalg.lstsq(parts, signal.astype(complex), rcond=None)[0]
    left = signal - (parts @ weights).real
    swing = signal - signal.mean(axis=0)
    power, rest, noise = float(np.sum(swing**2)), float(np.sum(left**2)), samples * white_noise(left)
    # Noise is no part of the decay; but what is hardly more than noise is none.
    if power < AUDIBLE * noise or power == 0.0:
        return exponents, 2.0 * np.linalg.norm(weights, axis=1), 0.0
    explained = 1.0 - max(rest - noise, 0.0) / (power - noise)
    energy = 0.5 * np.sum(np.abs(parts) ** 2, axis=0) * np.sum(np.abs(2.0 * weights) ** 2, axis=1)
    weights[energy < HEARD * noise / samples] = 0.0
    return exponents, 2.0 * np.linalg.norm(weights, axis=1), explained


def white_noise(left: Array) -> float:
    """Return the power of the white noise in what a model leaves of a signal (K, d), all directions together.

    The median of the lines is that of the noise alone, where something else has a few of them.
    """
    lines = np.sum(np.abs(np.fft.rfft(left, axis=0)[1:]) ** 2, axis=1) / len(left)
    directions = left.shape[1]
    return float(np.median(lines)) / (1.0 - 1.0 / (9.0 * directions)) ** 3  # median of a chi-square


def thinned(signal: Array, period: float, fastest: float) -> tuple[Array, float, int]:
    """Low-pass and thin a decay; the signal, its period, and the samples that were lost at its beginning."""
    step = int(1.0 / (period * OVERSAMPLED * fastest))
    step = max(1, min(step, len(signal) // 60))
    if step == 1:
        return signal, period, 0
    taps = firwin(4 * step + 1, 0.8 / step)
    kept = np.stack([np.convolve(column, taps, mode="valid") for column in signal.T], axis=1)
    return kept[::step], step * period, 2 * step


def fastest_of(signal: Array, period: float) -> float:
    """Return the highest frequency that has a part in a signal, Hz."""
    window = np.hanning(len(signal))[:, None]
    lines = np.linalg.norm(np.fft.rfft((signal - signal.mean(axis=0)) * window, axis=0), axis=1)
    frequency = np.fft.rfftfreq(len(signal), period)
    lines[frequency * period * len(signal) < 2.0] = 0.0  # what drifts
    least = max(SMALL * lines.max(), AUDIBLE_LINE * float(np.median(lines)))
    heard = np.flatnonzero(lines >= min(least, lines.max()))
    return float(frequency[heard[-1]])


def identify(signal: Array, period: float) -> tuple[tuple[Mode, ...], float]:
    """Return the modes of a free decay (K, d), by falling amplitude, and the share of it they explain.

    As `told_apart`, without the harmonics.
    """
    modes, _, explained = told_apart(signal, period)
    return modes, explained


def told_apart(signal: Array, period: float) -> tuple[tuple[Mode, ...], tuple[Harmonic, ...], float]:
    """Return the modes of a free decay (K, d), by falling amplitude, harmonics, and the share explained.

    `period` is that between samples, s. A mode is what several orders of the model, and the decay's parts,
    agree on.
    """
    if len(signal) < LEAST_SAMPLES or not np.isfinite(signal).all() or not np.ptp(signal, axis=0).any():
        return (), (), 0.0
    fastest = fastest_of(signal, period)
    decay, dt, _ = thinned(signal, period, fastest)
    decay = decay[:SAMPLES]
    decay = decay - decay.mean(axis=0)
    fits = [poles(decay, dt, order) for order in ORDERS if order < len(decay) // 4]
    if not fits:
        return (), (), 0.0
    # The smallest model that leaves hardly more than the largest does.
    best = max(share for _, _, share in fits)
    chosen = next(n for n, fit in enumerate(fits) if 1.0 - fit[2] <= 1.5 * (1.0 - best) + 1e-6)
    exponents, amplitudes, share = fits[chosen]
    others = [*fits[chosen + 1 : chosen + 3], *fits[max(0, chosen - 1) : chosen]]
    order = ORDERS[chosen]
    half = len(decay) // 4
    parts = [poles(decay[:-half], dt, order), poles(decay[half:], dt, order)]
    lowest = 1.0 / (dt * len(decay))
    swings = exponents.imag > 2.0 * np.pi * lowest
    largest = float(amplitudes[swings].max()) if swings.any() else 0.0
    modes = []
    for exponent, amplitude in zip(exponents, amplitudes, strict=True):
        frequency, damping = abs(exponent) / (2.0 * np.pi), -exponent.real / abs(exponent)
        if exponent.imag <= 0.0 or amplitude < SMALL * largest or not lowest < frequency < 0.45 / dt:
            continue
        if not -0.01 < damping < MOST_DAMPED:
            continue
        known = [nearest(frequency, fit[0]) for fit in others]
        agreed = [d for f, d in known if abs(f - frequency) <= STABLE[0] * frequency]
        if others and not any(abs(d - damping) <= STABLE[1] * abs(damping) + 1e-4 for d in agreed):
            continue
        seen = [damping, *agreed]
        seen += [d for f, d in (nearest(frequency, fit[0]) for fit in parts)
                 if abs(f - frequency) <= STABLE[0] * frequency]  # fmt: skip
        spread = 0.5 * float(max(seen) - min(seen))
        modes.append(Mode(float(frequency), float(damping), float(amplitude), spread))
    own, harmonics = apart(sorted(modes, key=lambda m: -m.amplitude))
    return own, harmonics, share


def apart(modes: list[Mode]) -> tuple[tuple[Mode, ...], tuple[Harmonic, ...]]:
    """Tell modes, by falling amplitude, from what comes of them and dies away as fast as they do together."""
    own: list[Mode] = []
    harmonics: list[Harmonic] = []
    for mode in modes:
        rate = mode.damping * mode.frequency
        known = [
            h for h in origins(mode.frequency, mode.amplitude, [(m.frequency, m.amplitude) for m in own])
            if abs(rate - sum(n * own[k].damping * own[k].frequency for k, n in h.parts))
            <= ALIKE * rate + mode.spread * mode.frequency + 1e-3 * mode.frequency
        ]  # fmt: skip
        if known:
            harmonics.append(min(known, key=lambda h: abs(h.expected - mode.frequency)))
        else:
            own.append(mode)
    return tuple(own), tuple(harmonics)


def nearest(frequency: float, exponents: NDArray[np.complex128]) -> tuple[float, float]:
    """Return frequency and damping ratio of the pole nearest to a frequency."""
    upper = exponents[exponents.imag > 0.0]
    if not len(upper):
        return 0.0, 0.0
    near = upper[np.argmin(np.abs(np.abs(upper) / (2.0 * np.pi) - frequency))]
    return float(abs(near) / (2.0 * np.pi)), float(-near.real / abs(near))


def search(
    time: Array, signal: Array, moved: NDArray[np.bool_] | None = None, most: int = 3
) -> tuple[list[RingDown], list[str]]:
    """Find the free decays in a motion, and their modes; the largest first.

    Parameters
    ----------
    time : ndarray (K,), s, evenly spaced
    signal : ndarray (K, d)
    moved : ndarray (K,) of bool or None
        Where something is known to drive the robot along its way.
    most : int
        So many are looked for.

    Returns
    -------
    the decays; why stretches in which the motion dies away are none, a sentence each
    """
    found: list[RingDown] = []
    if len(time) < 2 * LEAST_SAMPLES:
        return found, [f"there are {len(time)} samples; a free decay needs {2 * LEAST_SAMPLES}"]
    period = float((time[-1] - time[0]) / (len(time) - 1))
    windows = candidates(signal, period, moved)
    if not windows:
        return found, ["nowhere does a vibration die away over three of its periods"]
    why_not: list[str] = []
    for window in windows:
        begin, end = window.begin, window.end
        if any(time[begin] < r.end and time[end - 1] > r.begin for r in found):
            continue
        tried: list[RingDown] = []
        share = 0.0
        for part in (0.0, 0.08, 0.16, 0.25, 0.4):
            first = begin + round(part * (end - begin))
            modes, harmonics, explained = told_apart(signal[first:end], period)
            share = max(share, explained)
            if modes and (end - first) * period * modes[0].frequency >= LEAST_PERIODS:
                last = min(end, len(time)) - 1
                tried.append(RingDown(float(time[first]), float(time[last]), modes, explained, harmonics))
                if explained >= GOOD:
                    break
        where = f"from {time[begin]:.3g} to {time[end - 1]:.3g} s, about {window.frequency:.3g} Hz: "
        if not tried:
            why_not.append(
                f"{where}only {end - begin} samples, {LEAST_SAMPLES} are needed"
                if end - begin < LEAST_SAMPLES
                else f"{where}models of different orders do not agree on a mode of at least three periods"
            )
            continue
        best = max(tried, key=lambda r: r.explained)
        if best.explained >= EXPLAINED:
            found.append(best)
        else:
            why_not.append(
                f"{where}damped sines explain {100.0 * share:.0f} % of it,"
                f" {100.0 * EXPLAINED:.0f} % are needed"
            )
        if len(found) == most:
            break
    return sorted(found, key=lambda r: -r.modes[0].amplitude), why_not[:MOST_REASONS]


def ring_downs(
    time: Array, signal: Array, moved: NDArray[np.bool_] | None = None, most: int = 3
) -> list[RingDown]:
    """Return the decays of `search`."""
    return search(time, signal, moved, most)[0]
