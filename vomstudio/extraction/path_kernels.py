"""Compiled inner loops of paths over a graph.

The neighbours of node i are near[starts[i]:starts[i + 1]]. Nothing here allocates: what is written
comes in as arguments.
"""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel, part


@kernel("void(i8[::1], i8[::1], i8[::1], i4[::1])")
def neighbours(first, second, starts, near):  # type: ignore[no-untyped-def]
    """Lists of neighbours from the two ends of each arc, each at the other. starts (n + 1,) comes
    in as zeros."""
    for arc in range(len(first)):
        starts[first[arc] + 1] += 1
        starts[second[arc] + 1] += 1
    for node in range(1, len(starts)):
        starts[node] += starts[node - 1]
    # Filled from the front, each list moves its own start, which is put back afterwards.
    for arc in range(len(first)):
        a, b = first[arc], second[arc]
        near[starts[a]] = b
        starts[a] += 1
        near[starts[b]] = a
        starts[b] += 1
    for node in range(len(starts) - 1, 0, -1):
        starts[node] = starts[node - 1]
    starts[0] = 0


@kernel("i8(i8[::1], i4[::1])")
def without_repeats(starts, near):  # type: ignore[no-untyped-def]
    """Put each node's neighbours in order and leave each of them once, in place: how many there are
    in all."""
    count, begin = 0, starts[0]
    for node in range(len(starts) - 1):
        end = starts[node + 1]
        for at in range(begin + 1, end):
            value, to = near[at], at
            while to > begin and near[to - 1] > value:
                near[to] = near[to - 1]
                to -= 1
            near[to] = value
        starts[node] = count
        # What is written lies before what is still to be read.
        last = -1
        for at in range(begin, end):
            value = near[at]
            if value != last:
                near[count], last = value, value
                count += 1
        begin = end
    starts[len(starts) - 1] = count
    return count


@part
def _by_way_of(places, node, one, other):  # type: ignore[no-untyped-def]
    """From one place to another by way of a node."""
    x, y, z = places[node, 0], places[node, 1], places[node, 2]
    far = math.sqrt((x - one[0]) ** 2 + (y - one[1]) ** 2 + (z - one[2]) ** 2)
    return far + math.sqrt((x - other[0]) ** 2 + (y - other[1]) ** 2 + (z - other[2]) ** 2)


@kernel("i8(f8[:,::1], i8[::1], i4[::1], i8, f8[::1], f8[::1], f8, i8[::1], i8[::1])")
def within(places, starts, near, first, one, other, reach, mark, rows):  # type: ignore[no-untyped-def]
    """The nodes that hang together with `first` inside the ellipsoid whose points' distances from
    `one` and `other` sum to `reach`: how many, written to rows; -1 where rows has no room for them.
    mark (n,) is -1 on the way in and out."""
    rows[0] = first
    mark[first] = 0
    count, done = 1, 0
    while 0 <= done < count:
        node = rows[done]
        done += 1
        for at in range(starts[node], starts[node + 1]):
            to = near[at]
            if mark[to] >= 0 or _by_way_of(places, to, one, other) > reach:
                continue
            if count == len(rows):
                done = -1
                break
            mark[to] = 0
            rows[count] = to
            count += 1
    for at in range(count):
        mark[rows[at]] = -1
    return count if done >= 0 else -1


@kernel("i8(f8[:,::1], f8[::1], f8[::1], f8, i8[::1])")
def inside(places, one, other, reach, rows):  # type: ignore[no-untyped-def]
    """All nodes inside that ellipsoid, in their order: how many, written to rows (n,). Many are
    found faster so than from neighbour to neighbour."""
    count = 0
    x, y, z = 0.5 * (one[0] + other[0]), 0.5 * (one[1] + other[1]), 0.5 * (one[2] + other[2])
    # The ball around it, a little larger for rounding, leaves out most without a root.
    most = 0.25 * reach * reach * (1.0 + 1e-9)
    for node in range(len(places)):
        right, up, ahead = places[node, 0] - x, places[node, 1] - y, places[node, 2] - z
        if right * right + up * up + ahead * ahead > most:
            continue
        if _by_way_of(places, node, one, other) <= reach:
            rows[count] = node
            count += 1
    return count


@kernel("i8(i8[::1], i4[::1], i8, b1[::1], i8[::1])")
def together(starts, near, first, met, rows):  # type: ignore[no-untyped-def]
    """How many nodes hang together with `first`, which come to be true in met (n,); rows (n,) is
    space."""
    rows[0], met[first] = first, True
    count, done = 1, 0
    while done < count:
        node = rows[done]
        done += 1
        for at in range(starts[node], starts[node + 1]):
            if not met[near[at]]:
                met[near[at]] = True
                rows[count] = near[at]
                count += 1
    return count


@kernel("i8(i8[::1], i4[::1], i8[::1], i8[::1], i8[::1], i4[::1])")
def part_of(starts, near, rows, number, new_starts, new_near):  # type: ignore[no-untyped-def]
    """The graph of some nodes alone: how long its list of neighbours is. number (n,) is the place
    of a node among rows, -1 of the others."""
    count = 0
    for i in range(len(rows)):
        new_starts[i] = count
        for at in range(starts[rows[i]], starts[rows[i] + 1]):
            to = number[near[at]]
            if to >= 0:
                new_near[count] = to
                count += 1
    new_starts[len(rows)] = count
    return count


@kernel("void(i8[::1], i4[::1], f8[::1], f8[::1], i8, i8)")
def means(starts, near, values, out, first, last):  # type: ignore[no-untyped-def]
    """The mean (n,) of each node's value and its neighbours', of the nodes first to last - 1."""
    begin = starts[first]
    for node in range(first, last):
        end = starts[node + 1]
        total = values[node]
        for at in range(begin, end):
            total += values[near[at]]
        out[node] = total / (1.0 + end - begin)
        begin = end


@part
def _distance(places, a, b):  # type: ignore[no-untyped-def]
    x, y = places[a, 0] - places[b, 0], places[a, 1] - places[b, 1]
    z = places[a, 2] - places[b, 2]
    return math.sqrt(x * x + y * y + z * z)


@kernel("void(f8[:,::1], i8[::1], i4[::1], f8[::1], f8[:,::1])")
def slopes(places, starts, near, values, out):  # type: ignore[no-untyped-def]
    """Change of a value per unit of length at each node, as a vector: the mean of that along its
    arcs. On a speckle the sides cancel."""
    for node in range(len(values)):
        x, y, z = 0.0, 0.0, 0.0
        for at in range(starts[node], starts[node + 1]):
            to = near[at]
            far = max(_distance(places, node, to), 1e-12)
            change = (values[to] - values[node]) / (far * far)
            x += change * (places[to, 0] - places[node, 0])
            y += change * (places[to, 1] - places[node, 1])
            z += change * (places[to, 2] - places[node, 2])
        count = max(starts[node + 1] - starts[node], 1)
        out[node, 0], out[node, 1], out[node, 2] = x / count, y / count, z / count


# --- a heap of nodes: four below each, their keys beside them, which are read in one piece --------
@part
def _raise(keys, heap, place, at):  # type: ignore[no-untyped-def]
    """Move what is at a place of the heap toward its root."""
    node, key = heap[at], keys[at]
    while at > 0:
        above = (at - 1) >> 2
        if keys[above] <= key:
            break
        heap[at], keys[at] = heap[above], keys[above]
        place[heap[at]] = at
        at = above
    heap[at], keys[at], place[node] = node, key, at


@part
def _without_root(keys, heap, place, size):  # type: ignore[no-untyped-def]
    """Take the root away: the new size."""
    place[heap[0]] = -1
    size -= 1
    node, key, at = heap[size], keys[size], 0
    while True:
        first = 4 * at + 1
        if first >= size:
            break
        least = first
        for other in range(first + 1, min(first + 4, size)):
            if keys[other] < keys[least]:
                least = other
        if keys[least] >= key:
            break
        heap[at], keys[at] = heap[least], keys[least]
        place[heap[at]] = at
        at = least
    if size > 0:
        heap[at], keys[at], place[node] = node, key, at
    return size


@part
def _put(keys, heap, place, size, node, key):  # type: ignore[no-untyped-def]
    """Put a node in, or move it up to a smaller key: the new size. place is -1 for what is not in
    the heap."""
    at = place[node]
    if at < 0:
        at, size = size, size + 1
        heap[at], place[node] = node, at
    keys[at] = key
    _raise(keys, heap, place, at)
    return size


@kernel(
    "b1(f8[:,::1], i8[::1], i4[::1], f8[::1], i8, i8, f8, "
    "f8[::1], i4[::1], f8[::1], i4[::1], i4[::1])"
)
def least_cost(places, starts, near, costs, one, other, least, distance, before, keys, heap, place):  # type: ignore[no-untyped-def]
    """The search of Dijkstra from one node until another is reached: whether it is. An arc costs
    its length times the mean of what a metre costs at its ends.

    least : that no metre costs less; above 0 what is still to go is reckoned with it (A*, Hart,
    Nilsson & Raphael 1968). distance comes in as infinity, place as -1; before is the node that
    each is reached from. keys, heap (n,) are space.
    """
    distance[one], before[one] = 0.0, -1
    size = _put(keys, heap, place, 0, one, 0.0)
    while size > 0:
        node = heap[0]
        if node == other:
            return True
        size = _without_root(keys, heap, place, size)
        base = distance[node]
        for at in range(starts[node], starts[node + 1]):
            to = near[at]
            # Two places at no distance still are an arc.
            step = max(_distance(places, node, to) * 0.5 * (costs[node] + costs[to]), 1e-15)
            total = base + step
            if total < distance[to]:
                distance[to] = total
                before[to] = node
                ahead = least * _distance(places, to, other) if least > 0.0 else 0.0
                size = _put(keys, heap, place, size, to, total + ahead)
    return False


@part
def _slot_of(node, slots, nodes, count, headings, distance, place):  # type: ignore[no-untyped-def]
    """Where the states of a node are, made ready when it is first met; nodes is full at -1."""
    slot = slots[node]
    if slot >= 0 or count == len(nodes):
        return slot
    slots[node], nodes[count] = count, node
    for state in range(count * headings, (count + 1) * headings):
        distance[state], place[state] = math.inf, -1
    return count


@kernel(
    "i8(f8[:,::1], f8[:,::1], i8[::1], i4[::1], f8[::1], i8, i8, f8[::1], f8, i8, f8, "
    "i4[::1], i4[::1], f8[::1], i4[::1], f8[::1], i4[::1], i4[::1])"
)
def least_turning(  # type: ignore[no-untyped-def]
    places,
    flat,
    starts,
    near,
    costs,
    one,
    other,
    rest,
    turn,
    headings,
    widest,
    slots,
    nodes,
    distance,
    before,
    keys,
    heap,
    place,
):
    """The same over states: to be at a node with one of so many headings around the circle. From a
    state lead the arcs within an angle (cosine `widest`) of its heading in the plane, flat (n, 2);
    and to the next heading to either side, which costs `turn`. The state at the other node; -1
    where there is no way, -2 where more nodes were met than there is room for.

    rest (n,) is what it costs at least from a node to the other, which no arc's cost undercuts.
    slots (n,) comes in as -1; state slot * headings + h is at nodes[slot]. All else is space.
    """
    count = _slot_of(one, slots, nodes, 0, headings, distance, place) + 1
    size = 0
    for state in range(headings):
        distance[state], before[state] = 0.0, -1
        size = _put(keys, heap, place, size, state, rest[one])
    while size > 0:
        state = heap[0]
        slot, h = state // headings, state % headings
        node = nodes[slot]
        if node == other:
            return state
        size = _without_root(keys, heap, place, size)
        base = distance[state]
        for side in (1, headings - 1):
            to = slot * headings + (h + side) % headings
            if base + turn < distance[to]:
                distance[to] = base + turn
                before[to] = state
                size = _put(keys, heap, place, size, to, base + turn + rest[node])
        angle = 2.0 * math.pi * h / headings
        x, y = math.cos(angle), math.sin(angle)
        for at in range(starts[node], starts[node + 1]):
            end = near[at]
            right, up = flat[end, 0] - flat[node, 0], flat[end, 1] - flat[node, 1]
            # What leads straight out of the plane has no direction in it.
            if right * x + up * y < widest * math.sqrt(right * right + up * up):
                continue
            step = max(_distance(places, node, end) * 0.5 * (costs[node] + costs[end]), 1e-15)
            there = _slot_of(end, slots, nodes, count, headings, distance, place)
            if there < 0:
                return -2
            count = max(count, there + 1)
            to = there * headings + h
            if base + step < distance[to]:
                distance[to] = base + step
                before[to] = state
                size = _put(keys, heap, place, size, to, base + step + rest[end])
    return -1
