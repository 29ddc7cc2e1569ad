"""The fields of the experiment: what they are called, what they admit. Menus, flags, links and messages read this."""

from __future__ import annotations

from tracker_core import adaptive
from tracker_core.adaptive import METHODS
from tracker_core.checks import Domain, Field, choice
from tracker_core.conventions import CONVENTIONS, GAIN
from tracker_core.design import DESIGNS, MANUAL
from tracker_core.gating import WIDTH
from tracker_core.manoeuvre import MANOEUVRE_STD, MANOEUVRES
from tracker_core.measured import RECORDING
from tracker_core.noise import CORRELATION, NOISES
from tracker_core.scenarios import SCENARIOS
from tracker_core.starts import STARTS
from tracker_core.types import ORDERS

SAMPLES = Domain(3, 200_000, whole=True)
INTERVAL = Domain(1e-6, 1e6)
NOISE_STD = Domain(0, 1e9)
SEED = Domain(0, 2**53 - 1, whole=True)
SNR = Domain(-300, 1e30)
NOISE_LEVELS = {"std": "σ", "snr": "SNR, ratio of powers", "snr-decibel": "SNR, decibel"}

FIELDS: dict[str, Field] = {
    "scenario": choice("Scenario", "The target and its true motion, or your own recording.", [*SCENARIOS, RECORDING]),
    "data": Field(
        "", "Recording", "", "The content of the file that was recorded, in 32 hexadecimal digits.", "text",
        Domain(1, 100)),
    "reading": Field("", "Reading", "", "How the file is read: columns, units, time.", "text", Domain(1, 600)),
    "samples": Field("n", "Samples", "", "How many measurements are taken.", "whole", SAMPLES),
    "interval": Field("T", "Interval", "s", "Time between two measurements.", "number", INTERVAL),
    "noise": choice("Noise", "What kind of error the measurements carry.", NOISES),
    "noise_level": choice("Noise given as", "What the number beside it means.", NOISE_LEVELS),
    "noise_std": Field(
        "σ", "Noise std", "m", "Standard deviation of the measurement error; one number, or one per axis.",
        "numbers", NOISE_STD),
    "snr": Field(
        "", "SNR", "", "Mean square of the true position over that of its error, the same for every axis.", "number",
        SNR),
    "noise_correlation": Field(
        "ρ", "Correlation", "", "Of one error with the next: n(k) = ρ n(k−1) + √(1−ρ²) e(k).", "number", CORRELATION),
    "manoeuvre": choice(
        "Manoeuvre noise", "Random pushes that the target gets and the filter does not know of.", MANOEUVRES),
    "manoeuvre_std": Field(
        "σ_w", "Push std", "", "Standard deviation of the pushes: m/s² for an acceleration, m/s³ for a jerk.", "number",
        MANOEUVRE_STD),
    "seed": Field(
        "", "Seed", "", "The same seed draws the same noise, and the same random target, everywhere.", "whole", SEED),
    "gate": Field(
        "", "Outlier gate", "σ", "A measurement whose innovation is greater than so many of its standard deviations is "
        "not believed; empty for no gate.", "number", WIDTH),
    "start": choice("Start", "Where the filter's first state comes from.", STARTS),
    "order": Field(
        "", "Order", "", "Number of states per axis: 2 tracks velocity, 3 acceleration, 4 jerk.",
        "whole", Domain(min(ORDERS), max(ORDERS), whole=True)),
    "convention": choice(
        "Gain convention", "What γ and η multiply; changing it rewrites the numbers and leaves the filter.",
        CONVENTIONS),
    "design": choice(
        "Design", "The formula that computes the gains, the method that chooses them as it runs, or manual.",
        dict.fromkeys([MANUAL, *DESIGNS, *METHODS])),
    "alpha": Field("α", "Position gain", "", "Share of the innovation that corrects the position.", "number", GAIN),
    "beta": Field("β", "Velocity gain", "", "Corrects the velocity by β e/T.", "number", GAIN),
    "gamma": Field("γ", "Acceleration gain", "", "Corrects the acceleration.", "number", GAIN),
    "eta": Field("η", "Jerk gain", "", "Corrects the jerk.", "number", GAIN),
    "xi": Field("ξ", "Fading factor", "", "Weight of the past per sample: near 1 smooth, near 0 responsive.",
                "number"),
    "tracking_index": Field(
        "Λ", "Tracking index", "", "Λ = σ_w T²/σ_v (order 4: T³): manoeuvre against measurement noise.", "number"),
    **adaptive.PARAMETERS,
}  # fmt: skip
