"""What a hand moves: menus, boxes, sliders, switches, each with its label, its explanation and its error.

Inputs are native elements, so that keyboard, touch and screen readers work as everywhere else; Dash has no component
for them, so a placeholder carries their attributes and assets/desk.js puts the element into it.
"""

from __future__ import annotations

from collections.abc import Sequence

from dash import html
from dash.development.base_component import Component

from layouts.components import typeset


def error_line(page: str, name: str) -> Component:
    """Where the message about a field appears."""
    return html.Div(id=f"{page}-{name}-error", className="field-error", role="alert")


def about(page: str, name: str, sentence: str) -> Component:
    """What explains a field: told with its control, and shown beside it by assets/tips.js."""
    return html.Span(sentence, id=f"{page}-{name}-about", hidden=True)


def told(page: str, name: str) -> dict[str, str]:
    """What a screen reader is told of a control beside its label; of inputs assets/desk.js says the same."""
    return {"aria-describedby": f"{page}-{name}-about {page}-{name}-error"}


def select_field(
    page: str, name: str, label: str, sentence: str, options: Sequence[tuple[str, str]], groups: Sequence[str] = ()
) -> Component:
    """A labelled native menu.

    Args:
        page: prefix of the id.
        name: of the control.
        label, sentence: what it is, in short and plainly.
        options: value and title of every choice.
        groups: per option the heading it stands under; empty for none.
    """
    return html.Div(
        [
            html.Label(label, htmlFor=f"{page}-{name}", className="tip"),
            html.Select(_options(options, groups), id=f"{page}-{name}", **{"data-control": name}, **told(page, name)),
            about(page, name, sentence),
            error_line(page, name),
        ],
        className=f"field field-{name}",
    )


def _options(options: Sequence[tuple[str, str]], groups: Sequence[str]) -> list[Component]:
    if not groups:
        return [html.Option(title, value=value) for value, title in options]
    parts: list[Component] = []
    for heading in dict.fromkeys(groups):
        inside = [
            html.Option(title, value=value)
            for (value, title), group in zip(options, groups, strict=True)
            if group == heading
        ]
        parts += [html.Optgroup(inside, label=heading)] if heading else inside
    return parts


def box_field(page: str, name: str, label: str, sentence: str, unit: str | None = "") -> Component:
    """A labelled box for a number; a unit that depends on others, None here, comes with answers as text `NAME-unit`."""
    caption = f"{label} ({unit})" if unit else label
    title = [*typeset(caption), *([html.Span(id=f"{page}-{name}-unit")] if unit is None else [])]
    return html.Div(
        [
            html.Label(title, htmlFor=f"{page}-{name}", className="tip"),
            box(page, name, caption),
            about(page, name, sentence),
            error_line(page, name),
        ],
        className=f"field field-{name}",
    )


def box(page: str, name: str, label: str) -> Component:
    """Placeholder of a number box."""
    return html.Div(
        className="placeholder",
        **{"data-input": "box", "data-id": f"{page}-{name}", "data-control": name, "data-label": label},
    )


def slider(page: str, name: str, label: str) -> Component:
    """Placeholder of a slider."""
    return html.Div(
        className="placeholder slider",
        **{"data-input": "slider", "data-id": f"{page}-{name}-slider", "data-control": name, "data-label": label},
    )


def slider_field(page: str, name: str, symbol: str, title: str, sentence: str) -> Component:
    """A gain: symbol, slider and number box in one row."""
    return html.Div(
        [
            html.Label(
                [html.Span(symbol, className="symbol"), html.Span(title, className="visually-hidden")],
                htmlFor=f"{page}-{name}-slider",
                className="tip",
            ),
            slider(page, name, f"{symbol} {title}"),
            box(page, name, f"{symbol} {title}, number"),
            html.Span(className="owner", id=f"{page}-{name}-owner"),
            about(page, name, f"{title}. {sentence}"),
            error_line(page, name),
        ],
        className=f"gain gain-{name}",
        id=f"{page}-{name}-row",
    )  # fmt: skip


def sample_cursor(page: str, label: str) -> Component:
    """A slider over the samples of the run, and a box that reaches every one of them.

    Args:
        page: prefix of the ids.
        label: what a screen reader is told that they choose.
    """
    return html.Div(
        [html.Label("Sample", htmlFor=f"{page}-at-slider"), *sample_inputs(page, label)],
        className="cursor",
    )


def sample_inputs(page: str, label: str) -> list[Component]:
    """Slider and box of the chosen sample, of how many, and its time.

    The latter are not read out: slider and box say which it is, and a played run would never end.
    """
    return [
        slider(page, "at", label),
        box(page, "at", f"{label}, number"),
        html.Output(id=f"{page}-at-text", **{"aria-live": "off"}),
        error_line(page, "at"),
    ]


def parameter_field(page: str, name: str, title: str, sentence: str, unit: str = "") -> Component:
    """A number with a slider under its title."""
    caption = f"{title} ({unit})" if unit else title
    return html.Div(
        [
            html.Label(caption, htmlFor=f"{page}-{name}-slider", className="tip"),
            slider(page, name, caption),
            box(page, name, f"{caption}, number"),
            about(page, name, sentence),
            error_line(page, name),
        ],
        className=f"parameter field-{name}",
    )


def switch_field(page: str, name: str, label: str, sentence: str) -> Component:
    """A switch that is on or off."""
    return html.Div(
        [
            html.Div(
                className="placeholder",
                **{"data-input": "switch", "data-id": f"{page}-{name}", "data-control": name, "data-label": label},
            ),
            html.Label(label, htmlFor=f"{page}-{name}", className="tip"),
            about(page, name, sentence),
            error_line(page, name),
        ],
        className=f"switch field-{name}",
    )


def choice_field(page: str, name: str, label: str, options: Sequence[tuple[str, str]]) -> Component:
    """One of a few choices that all stand there: native radio buttons in a row.

    Args:
        page: prefix of the ids.
        name: of the control.
        label: what is chosen.
        options: value and title of every choice.
    """
    parts: list[Component] = [html.Legend(label, className="visually-hidden")]
    for value, title in options:
        place = {"input": "radio", "id": f"{page}-{name}-{value}", "control": name, "label": title, "value": value}
        parts.append(
            html.Div(
                [
                    html.Div(className="placeholder", **{f"data-{key}": said for key, said in place.items()}),
                    html.Label(title, htmlFor=f"{page}-{name}-{value}"),
                ],
                className="choice",
            )
        )
    return html.Fieldset([*parts, error_line(page, name)], className=f"choices field-{name}")
