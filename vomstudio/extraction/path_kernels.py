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


@kernel("i8(f8[:,::1], i8[::1], i4[::1], i8, f8[::1], f8[::1], f8, i8[::1], i8[::1])")
def within(places, starts, near, first, one, other, reach, mark, rows):  # type: ignore[no-untyped-def]
    """The nodes that hang together with `first` inside the ellipsoid whose points' distances from
    `one` and `other` sum to `reach`: how many, written to rows. mark (n,) is -1 where a node was
    not met yet; those that were met are marked, and must be put back."""
    rows[0] = first
    mark[first] = 0
    count, done = 1, 0
    while done < count:
        node = rows[done]
        done += 1
        for at in range(starts[node], starts[node + 1]):
            to = near[at]
            if mark[to] >= 0:
                continue
            x, y, z = places[to, 0], places[to, 1], places[to, 2]
            far = math.sqrt((x - one[0]) ** 2 + (y - one[1]) ** 2 + (z - one[2]) ** 2)
            far += math.sqrt((x - other[0]) ** 2 + (y - other[1]) ** 2 + (z - other[2]) ** 2)
            if far <= reach:
                mark[to] = 0
                rows[count] = to
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


@kernel("void(i8[::1], i4[::1], f8[::1], f8[::1])")
def means(starts, near, values, out):  # type: ignore[no-untyped-def]
    """The mean (n,) of each node's value and its neighbours'."""
    begin = starts[0]
    for node in range(len(values)):
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


@kernel("void(f8[:,::1], i8[::1], i4[::1], f8[::1], f8[::1])")
def slopes(places, starts, near, values, out):  # type: ignore[no-untyped-def]
    """Root mean square change of a value per unit of length along the arcs of each node."""
    for node in range(len(values)):
        total = 0.0
        for at in range(starts[node], starts[node + 1]):
            to = near[at]
            far = max(_distance(places, node, to), 1e-12)
            total += ((values[to] - values[node]) / far) ** 2
        out[node] = math.sqrt(total / max(starts[node + 1] - starts[node], 1))


@part
def _raise(heap, place, distance, at):  # type: ignore[no-untyped-def]
    """Move what is at a place of the heap toward its root."""
    node = heap[at]
    while at > 0:
        above = (at - 1) // 2
        if distance[heap[above]] <= distance[node]:
            break
        heap[at] = heap[above]
        place[heap[at]] = at
        at = above
    heap[at] = node
    place[node] = at


@part
def _lower(heap, place, distance, size):  # type: ignore[no-untyped-def]
    """Move what is at the root of the heap to where it belongs."""
    node, at = heap[0], 0
    while True:
        below = 2 * at + 1
        if below >= size:
            break
        if below + 1 < size and distance[heap[below + 1]] < distance[heap[below]]:
            below += 1
        if distance[heap[below]] >= distance[node]:
            break
        heap[at] = heap[below]
        place[heap[at]] = at
        at = below
    heap[at] = node
    place[node] = at


@kernel("b1(f8[:,::1], i8[::1], i4[::1], f8[::1], i8, i8, f8[::1], i4[::1], i4[::1], i4[::1])")
def least_cost(places, starts, near, costs, one, other, distance, before, heap, place):  # type: ignore[no-untyped-def]
    """Dijkstra's search from one node until another is reached: whether it is. An arc costs its
    length times the mean of what a metre costs at its ends. distance comes in as infinity; before
    is the node that each is reached from. heap, place (n,) are space."""
    distance[one] = 0.0
    heap[0], place[one], before[one] = one, 0, -1
    size = 1
    while size > 0:
        node = heap[0]
        if node == other:
            return True
        size -= 1
        if size > 0:
            heap[0] = heap[size]
            _lower(heap, place, distance, size)
        base = distance[node]
        for at in range(starts[node], starts[node + 1]):
            to = near[at]
            # Two places at no distance still are an arc.
            step = max(_distance(places, node, to) * 0.5 * (costs[node] + costs[to]), 1e-15)
            total = base + step
            known = distance[to]
            if total < known:
                distance[to] = total
                before[to] = node
                if known == math.inf:
                    heap[size] = to
                    place[to] = size
                    size += 1
                _raise(heap, place, distance, place[to])
    return False
