"""The lessons in words. Numbers and right answers come from facts.py: none is written down here."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

from layouts.pages.learn import facts
from layouts.pages.learn.facts import Facts

_TOGETHER = re.compile(r" (?==)|(?<==) |(?<=\d) (?=m\b|%)")


@dataclass(frozen=True, slots=True)
class Step:
    """A way into another page: what to look at there, what the page is called, and the address."""

    sentence: str
    page: str
    address: str = ""


@dataclass(frozen=True, slots=True)
class Lesson:
    """One question. Before its facts are known the texts have places for numbers, and the steps no address.

    Attributes:
        facts: compute what it comes to; their name is that of the lesson.
        title: in a few words.
        setting: what is given.
        question, choices: what is asked, and what may be predicted.
        answer: what happens and why, with numbers, a paragraph each.
        look: where it is seen before anything is predicted.
        steps: where it is seen afterwards.
        right: number of the choice that comes true.
    """

    facts: Callable[[], Facts]
    title: str
    setting: str
    question: str
    choices: tuple[str, ...]
    answer: tuple[str, ...]
    look: Step
    steps: tuple[Step, ...]
    right: int = -1

    @property
    def name(self) -> str:
        """Its anchor."""
        return self.facts.__name__

    def told(self) -> Lesson:
        """The same with its facts."""
        found = self.facts()

        def said(text: str) -> str:
            joined = " ".join(text.format(**found.numbers).replace("%", " %").split())
            # A number and what belongs to it stay on one line.
            return _TOGETHER.sub("\u00a0", joined)

        look, *steps = (
            replace(step, sentence=said(step.sentence), address=way)
            for step, way in zip((self.look, *self.steps), found.ways, strict=True)
        )
        return replace(
            self,
            setting=said(self.setting),
            question=said(self.question),
            choices=tuple(map(said, self.choices)),
            answer=tuple(map(said, self.answer)),
            look=look,
            steps=tuple(steps),
            right=found.right,
        )


_LESSONS = (
    Lesson(
        facts.memory,
        title="Smooth or responsive",
        setting="""An aircraft flies straight legs and turns; a sensor sees it every second, with {noise:g} m of
            noise in each axis. An α-β filter with fading memory follows: ξ, here {short:g}, is what it keeps of the
            past from one sample to the next.""",
        question="ξ is raised to {long:g}. What becomes of the error of the smoothed position?",
        choices=(
            "Smaller on the straight legs, larger in the turns",
            "Larger on the straight legs, smaller in the turns",
            "Smaller everywhere: more measurements are averaged",
            "Larger everywhere: old measurements say nothing about now",
        ),
        answer=(
            """Over {runs} runs the RMS error goes from {straight:.1f} m to {straight_after:.1f} m on the straight
            legs, and from {turning:.1f} m to {turning_after:.1f} m in the turns.""",
            """Of the variance of the noise the filter lets {share:.0%} through before and {share_after:.0%} after. For
            every m/s² of a turn it lags by {lag:.1f} m before and by {lag_after:.1f} m after. No fixed gain is good
            at both: how much the target turns decides.""",
        ),
        look=Step("The aircraft and the filter", "Explore"),
        steps=(
            Step("The same with ξ = {long:g}: look at the error in the turns", "Explore"),
            Step("The error over all ξ is a valley, noise on one side and lag on the other", "Tune"),
            Step("What lag every pair of gains has, as colours behind the stable region", "Stability"),
        ),
    ),
    Lesson(
        facts.order,
        title="What an acceleration costs",
        setting="""An aircraft accelerates by {strength:.2g} m/s² all the time. The α-β filter with ξ = {xi:g}
            predicts with position and velocity alone.""",
        question="Once the start is forgotten, where is the smoothed position?",
        choices=(
            "It comes ever nearer to the truth, as measurements add up",
            "It stays behind by the same distance",
            "It falls behind farther and farther, as the velocity changes more and more",
        ),
        answer=(
            """Without noise it is {halfway:.2f} m away halfway through the run, and {end:.2f} m at its end. The
            correction by β then makes up at each sample for what the velocity has changed by since the last one.""",
            """The distance is a T² (1 − α)/β, here {strength:.4f} · {interval:g}² · (1 − {alpha:.4f})/{beta:.4f} =
            {lag:.2f} m. An α-β-γ filter, which keeps the acceleration as well, has no such lag, but lets
            {share_higher:.0%} of the variance of the noise through instead of {share:.0%}.""",
        ),
        look=Step("The aircraft and the filter", "Explore"),
        steps=(
            Step("The lag alone: the same without noise", "Explore"),
            Step("Order 3 with the same ξ: no lag, more noise", "Explore"),
            Step("The response to a parabola: input minus response goes to a constant", "Stability"),
        ),
    ),
    Lesson(
        facts.stability,
        title="Where it breaks",
        setting="""An α-β filter takes every measurement for the position (α = 1) and corrects its velocity by β of
            the innovation over the interval.""",
        question="β is raised slowly. Beyond which value is the filter unstable?",
        choices=(
            "{limits[0]:g}: no velocity can be corrected by more than all of the innovation",
            "{limits[1]:g}",
            "{limits[2]:g}",
            "None: as long as α is no more than 1, errors die out",
        ),
        answer=(
            """β must stay below 4 − 2α = {limit:.4g}. At β = {steady:g} the largest pole has magnitude {pole:.2f}:
            the errors of velocity and prediction change sign at every sample and die out. At β = {breaking:g} it has
            {pole_breaking:.2f}: {fails} fails, and they grow. The smoothed position shows nothing of it, since with
            α = 1 it is the measurement.""",
            """With a smaller α there is more room, at α = {small:g} up to β = {limit_small:.4g}. Beyond, at β =
            {beyond:g}, the error of the smoothed position grows as well, and the run is stopped at sample {sample}.
            Only filters that believe nearly all they measure come near this border; slow ones lie along the other,
            β = 0.""",
        ),
        look=Step("The filter at β = {mild:g}, and its poles", "Stability"),
        steps=(
            Step("β = {steady:g}: it rings, and is stable", "Stability"),
            Step("β = {breaking:g}: which inequality fails, by how much, and the nearest stable gains", "Stability"),
            Step("α = {small:g} and β = {beyond:g} on a target: where the run is stopped", "Explore"),
        ),
    ),
    Lesson(
        facts.prediction,
        title="Can a filter be worse than its sensor?",
        setting="""An aircraft in straight flight, and an α-β filter that is quick to believe: α = {eager[0]:g}, β =
            {eager[1]:g}. It is stable, and right on average.""",
        question="How large is the error of the predicted position, beside that of a single measurement?",
        choices=(
            "Smaller: it rests on all measurements before",
            "The same: with such gains it is little more than the last measurement",
            "Larger",
        ),
        answer=(
            """The variance of the prediction is {gain} times that of a measurement; that of the smoothed position
            is {share:.2f} times. The velocity is made of noisy positions, and the prediction carries its error one
            interval ahead.""",
            """Whoever uses predictions, for a gate or for pointing, looks at that number. With α = {calm[0]:g} and β =
            {calm[1]:g} it is {gain_calm:.2f}.""",
        ),
        look=Step("The aircraft and the filter", "Explore"),
        steps=(
            Step("Tracking RMSE, of the prediction, beside the RMSE of the measurements", "Explore"),
            Step("The same target with the calm filter", "Explore"),
            Step("Both variances, under Numbers at the foot of the page", "Stability"),
        ),
    ),
    Lesson(
        facts.luck,
        title="One run proves little",
        setting="""Two filters with fading memory on the same {samples} samples: A with ξ = {xi[0]:g}, B with ξ =
            {xi[1]:g}. With seed {seed} the RMS error of the smoothed position is {once[0]:.1f} m with A and
            {once[1]:.1f} m with B: {better} is better by {by:.0%}.""",
        question="""The target flies the same way {seeds} times, each with other noise. How often is {better} the better
            one?""",
        choices=("At least {often:.0%} of the time", "Often, and often not", "At most {seldom:.0%} of the time"),
        answer=(
            """{wins} times of {seeds}: by {won:.1f} m where it is better, and by {lost:.1f} m worse where it is not.
            On average the error is {means[0]:.1f} m with A and {means[1]:.1f} m with B.""",
            """Filters are compared on the same measurements, seed by seed. The error of {worse} is larger by {gain} m
            on average; with 95% confidence by {low} to {high} m. {verdict}.""",
        ),
        look=Step("Both filters on that run: A is pinned, B is the present one", "Compare"),
        steps=(
            Step(
                "{seeds} runs, further down: the difference with its interval, and whether it is significant", "Compare"
            ),
            Step("Where the best ξ lies, with its interval", "Tune"),
        ),
    ),
    Lesson(
        facts.innovations,
        title="Tuned without the truth",
        setting="""In a log file nobody knows where the target really was. What one has are the innovations: how far
            every measurement lies from its prediction.""",
        question="""ξ is chosen so that the innovations are smallest. Beside the ξ whose predictions are nearest to
            the truth, it is …""",
        choices=(
            "… the same, or nearly",
            "… clearly larger: a smooth filter has small innovations",
            "… clearly smaller: the filter learns to follow the noise",
        ),
        answer=(
            """The innovations are smallest at ξ = {seen:.3f}, the error of the prediction at ξ = {predicted:.3f}.
            The noise of a measurement has nothing to do with the prediction before it, so on average the squares add
            up: innovation² is error² plus the variance of the noise, and both are smallest at the same place.""",
            """That holds for predictions, and for white noise. The smoothed position is best at ξ = {smoothed:.3f}. And
            small innovations are not small errors: they are {least:.1f} m here at best, where the predictions are
            {error:.1f} m off and the sensor {noise:.1f} m.""",
        ),
        look=Step("The aircraft of the first lesson: its error over all ξ", "Tune"),
        steps=(
            Step("The same without the truth, and what not knowing it costs", "Tune"),
            Step("Load a log of your own, and tune on it in the same way", "Data"),
        ),
    ),
)


@cache
def lessons() -> tuple[Lesson, ...]:
    """All lessons, in the order in which they are read."""
    return tuple(lesson.told() for lesson in _LESSONS)
