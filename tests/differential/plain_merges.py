"""Merges of memories made of lists of dicts: what the central unit does, in the plainest way."""


def union_of_values(classes, tables):
    """Return the union of the classes, with the mean of each action over those who tried it."""
    union = []
    for table in tables:
        for row in table:
            goal, image = classes.find_or_append(union, row["key"], {"votes": None})
            goal["votes"] = goal["votes"] or {}
            for action, q in row["q"].items():
                goal["votes"].setdefault(image[action], []).append(q)
    for row in union:
        row["q"] = {a: mean(votes) for a, votes in row.pop("votes").items()}
    return union


def union_of_bests(classes, tables):
    """Return the union of the classes, with the best of the means of the actions voted for."""
    union = union_of_values(
        classes,
        [[{"key": row["key"], "q": {row["a"]: row["q"]}} for row in table] for table in tables],
    )
    for row in union:
        row["a"] = best_of(row["q"])
        row["q"] = row["q"][row["a"]]
    return union


def best_of(values):
    """Return the action of the highest value, the first of equals."""
    return min(values, key=lambda action: (-values[action], action))


def mean(votes):
    total = 0.0
    for vote in votes:
        total += vote
    return total / len(votes)


def copied(rows):
    return [dict(row) for row in rows]
