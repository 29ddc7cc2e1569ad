"""The Learn page: six questions, whose answers show once somebody has predicted them."""

from __future__ import annotations

from functools import cache

from dash import dcc, html
from dash.development.base_component import Component

from layouts.components import typeset
from layouts.pages.learn.lessons import Lesson, Step, lessons
from layouts.prepared import prepared


def layout(**_query: str) -> Component:
    """The page; assets/learn.js shows the answers."""
    beginning = {lesson.name: lesson.right for lesson in lessons()}
    return html.Div(
        [dcc.Store(id="learn-beginning", data=beginning), dcc.Store(id="learn-begun"), *_parts()],
        id="learn",
        className="desk",
        **{"data-state": "busy"},
    )


@cache
def _parts() -> tuple[Component, ...]:
    """What is the same for every visit."""
    return prepared(
        html.H1("Learn", className="visually-hidden"),
        _contents(),
        html.Div([_card(number, lesson) for number, lesson in enumerate(lessons(), 1)], className="lessons"),
    )


def _contents() -> Component:
    items = [
        html.Li(
            [
                html.A(_heading(number, lesson), href=f"#lesson-{lesson.name}", className="document"),
                html.Span(className="mark hint", **{"data-mark": lesson.name}),
            ]
        )
        for number, lesson in enumerate(lessons(), 1)
    ]
    return html.Nav(
        [
            html.H2("Six lessons"),
            html.P(
                "Each asks what will happen before it shows it. Numbers and answers are computed here, as on the pages "
                "that the links lead to.",
                className="hint",
            ),
            html.Ol(items, className="documents"),
            html.P(id="learn-score", className="hint"),
            html.P(id="learn-said", className="visually-hidden", role="status"),
            html.Button("Start again", id="learn-again", type="button", className="quiet", hidden=True),
        ],
        className="controls card contents",
        **{"aria-label": "Lessons"},
    )


def _heading(number: int, lesson: Lesson) -> str:
    return f"{number}. {lesson.title}"


def _card(number: int, lesson: Lesson) -> Component:
    part = f"lesson-{lesson.name}"
    choices = [
        html.Li(
            html.Button(
                [html.Span(typeset(choice)), html.Span(className="mark")],
                type="button",
                className="guess",
                **{"data-choice": str(index), "aria-pressed": "false"},
            )
        )
        for index, choice in enumerate(lesson.choices)
    ]
    asked = html.Div(
        [
            html.P(typeset(lesson.setting)),
            html.P(_step(lesson.look)),
            html.Div(
                [html.P(typeset(lesson.question), id=f"{part}-question", className="question"), html.Ul(choices)],
                className="guesses",
                role="group",
                **{"aria-labelledby": f"{part}-question"},
            ),
        ],
        className="lesson-part",
    )
    answer = html.Div(
        [
            html.P(className="verdict-line"),
            *(html.P(typeset(paragraph)) for paragraph in lesson.answer),
            html.H3("See it"),
            html.Ol([html.Li(_step(step)) for step in lesson.steps], className="steps"),
        ],
        className="lesson-part lesson-answer",
        hidden=True,
    )
    waiting = html.P("What happens shows once you have predicted it.", className="hint")
    return html.Section(
        [html.H2(_heading(number, lesson)), asked, html.Div([waiting, answer])],
        id=part,
        className="card lesson",
        **{"data-lesson": lesson.name},
    )


def _step(step: Step) -> list[Component]:
    return [dcc.Link(typeset(step.sentence), href=step.address), html.Span(f" in {step.page}", className="hint")]
