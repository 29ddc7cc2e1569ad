"""Tables of the pages, read back."""


def cells(component):
    """Caption, heading and rows of a table."""
    caption, head, body = component.children.children
    rows = [[cell.children for cell in row.children] for row in body.children]
    return caption.children, [cell.children for cell in head.children.children], rows
