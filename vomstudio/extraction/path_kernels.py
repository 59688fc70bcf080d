"""Compiled inner loops of path searches in a graph.

The neighbours of node i are neighbours[starts[i]:starts[i + 1]]. No function allocates memory:
results are written to arguments.
"""

from __future__ import annotations

import math

from vomstudio.geometry.kernels.jit import kernel, part


@kernel("void(i8[::1], i8[::1], i8[::1], i4[::1])")
def list_neighbours(first, second, starts, neighbours):  # type: ignore[no-untyped-def]
    """List the neighbours of nodes, given the ends of arcs; `starts` (n + 1,) must be zero."""
    for arc in range(len(first)):
        starts[first[arc] + 1] += 1
        starts[second[arc] + 1] += 1
    for node in range(1, len(starts)):
        starts[node] += starts[node - 1]
    # Filling a list advances its start; the starts are restored afterwards.
    for arc in range(len(first)):
        a, b = first[arc], second[arc]
        neighbours[starts[a]] = b
        starts[a] += 1
        neighbours[starts[b]] = a
        starts[b] += 1
    for node in range(len(starts) - 1, 0, -1):
        starts[node] = starts[node - 1]
    starts[0] = 0


@kernel("i8(i8[::1], i4[::1])")
def remove_duplicates(starts, neighbours):  # type: ignore[no-untyped-def]
    """Sort the neighbours of each node without duplicates, in place; return the new length."""
    count, begin = 0, starts[0]
    for node in range(len(starts) - 1):
        end = starts[node + 1]
        for k in range(begin + 1, end):
            value, slot = neighbours[k], k
            while slot > begin and neighbours[slot - 1] > value:
                neighbours[slot] = neighbours[slot - 1]
                slot -= 1
            neighbours[slot] = value
        starts[node] = count
        # The write position never passes the read position.
        previous_neighbour = -1
        for k in range(begin, end):
            value = neighbours[k]
            if value != previous_neighbour:
                neighbours[count], previous_neighbour = value, value
                count += 1
        begin = end
    starts[len(starts) - 1] = count
    return count


@part
def _detour_length(positions, node, start, end):  # type: ignore[no-untyped-def]
    """Return the distance from one position to another through a node."""
    x, y, z = positions[node, 0], positions[node, 1], positions[node, 2]
    distance = math.sqrt((x - start[0]) ** 2 + (y - start[1]) ** 2 + (z - start[2]) ** 2)
    return distance + math.sqrt((x - end[0]) ** 2 + (y - end[1]) ** 2 + (z - end[2]) ** 2)


@kernel("i8(f8[:,::1], i8[::1], i4[::1], i8, f8[::1], f8[::1], f8, i8[::1], i8[::1])")
def list_component_in_ellipsoid(  # type: ignore[no-untyped-def]
    positions, starts, neighbours, first, start, end, max_length, mark, rows
):
    """List the nodes connected to `first` within an ellipsoid, and return their number.

    The result is -1 if there are too many nodes.

    The ellipsoid contains the points for which the sum of the distances from `start` and `end`
    does not exceed `max_length`. The nodes are written to `rows`; `mark` (n,) must be -1 and is
    restored.
    """
    rows[0] = first
    mark[first] = 0
    count, done_count = 1, 0
    while 0 <= done_count < count:
        node = rows[done_count]
        done_count += 1
        for k in range(starts[node], starts[node + 1]):
            neighbour = neighbours[k]
            if (
                mark[neighbour] >= 0
                or _detour_length(positions, neighbour, start, end) > max_length
            ):
                continue
            if count == len(rows):
                done_count = -1
                break
            mark[neighbour] = 0
            rows[count] = neighbour
            count += 1
    for k in range(count):
        mark[rows[k]] = -1
    return count if done_count >= 0 else -1


@kernel("i8(f8[:,::1], f8[::1], f8[::1], f8, i8[::1])")
def list_nodes_in_ellipsoid(positions, start, end, max_length, rows):  # type: ignore[no-untyped-def]
    """List all nodes within an ellipsoid in `rows` (n,), and return their number.

    For many nodes, this is faster than `list_component_in_ellipsoid`.
    """
    count = 0
    x, y, z = 0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1]), 0.5 * (start[2] + end[2])
    # The enclosing sphere, slightly enlarged for rounding, excludes most nodes without a root.
    max_squared_radius = 0.25 * max_length * max_length * (1.0 + 1e-9)
    for node in range(len(positions)):
        right, up, forward = positions[node, 0] - x, positions[node, 1] - y, positions[node, 2] - z
        if right * right + up * up + forward * forward > max_squared_radius:
            continue
        if _detour_length(positions, node, start, end) <= max_length:
            rows[count] = node
            count += 1
    return count


@kernel("i8(i8[::1], i4[::1], i8, b1[::1], i8[::1])")
def mark_component(starts, neighbours, first, is_connected, rows):  # type: ignore[no-untyped-def]
    """Mark the nodes connected to `first` in `is_connected` (n,), and return their number."""
    rows[0], is_connected[first] = first, True
    count, done_count = 1, 0
    while done_count < count:
        node = rows[done_count]
        done_count += 1
        for k in range(starts[node], starts[node + 1]):
            if not is_connected[neighbours[k]]:
                is_connected[neighbours[k]] = True
                rows[count] = neighbours[k]
                count += 1
    return count


@kernel("i8(i8[::1], i4[::1], i8[::1], i8[::1], i8[::1], i4[::1])")
def extract_subgraph(starts, neighbours, rows, number, new_starts, new_neighbours):  # type: ignore[no-untyped-def]
    """Extract the subgraph of given nodes, and return the length of its list of neighbours.

    `number` (n,) is the index of each node among `rows`; -1 for other nodes.
    """
    count = 0
    for i in range(len(rows)):
        new_starts[i] = count
        for k in range(starts[rows[i]], starts[rows[i] + 1]):
            neighbour_number = number[neighbours[k]]
            if neighbour_number >= 0:
                new_neighbours[count] = neighbour_number
                count += 1
    new_starts[len(rows)] = count
    return count


@kernel("void(i8[::1], i4[::1], f8[::1], f8[::1], i8, i8)")
def average_neighbours(starts, neighbours, values, out, first, last):  # type: ignore[no-untyped-def]
    """Average the value of each node with its neighbours, for the nodes first to last - 1."""
    begin = starts[first]
    for node in range(first, last):
        end = starts[node + 1]
        total = values[node]
        for k in range(begin, end):
            total += values[neighbours[k]]
        out[node] = total / (1.0 + end - begin)
        begin = end


@part
def _distance(positions, a, b):  # type: ignore[no-untyped-def]
    x, y = positions[a, 0] - positions[b, 0], positions[a, 1] - positions[b, 1]
    z = positions[a, 2] - positions[b, 2]
    return math.sqrt(x * x + y * y + z * z)


@kernel("void(f8[:,::1], i8[::1], i4[::1], f8[::1], f8[:,::1])")
def compute_gradients(positions, starts, neighbours, values, out):  # type: ignore[no-untyped-def]
    """Write the gradient of a value at each node, the mean of the gradients along its arcs.

    At a speckle, the gradients along the arcs cancel each other.
    """
    for node in range(len(values)):
        x, y, z = 0.0, 0.0, 0.0
        for k in range(starts[node], starts[node + 1]):
            neighbour = neighbours[k]
            distance = max(_distance(positions, node, neighbour), 1e-12)
            change = (values[neighbour] - values[node]) / (distance * distance)
            x += change * (positions[neighbour, 0] - positions[node, 0])
            y += change * (positions[neighbour, 1] - positions[node, 1])
            z += change * (positions[neighbour, 2] - positions[node, 2])
        count = max(starts[node + 1] - starts[node], 1)
        out[node, 0], out[node, 1], out[node, 2] = x / count, y / count, z / count


# --- heap of nodes with four children each, whose adjacent keys are read together ----------------
@part
def _sift_up(keys, heap, heap_position, position):  # type: ignore[no-untyped-def]
    """Move an entry of the heap toward its root."""
    node, key = heap[position], keys[position]
    while position > 0:
        parent = (position - 1) >> 2
        if keys[parent] <= key:
            break
        heap[position], keys[position] = heap[parent], keys[parent]
        heap_position[heap[position]] = position
        position = parent
    heap[position], keys[position], heap_position[node] = node, key, position


@part
def _remove_root(keys, heap, heap_position, size):  # type: ignore[no-untyped-def]
    """Remove the root of the heap, and return the new size."""
    heap_position[heap[0]] = -1
    size -= 1
    node, key, position = heap[size], keys[size], 0
    while True:
        first = 4 * position + 1
        if first >= size:
            break
        smallest_child = first
        for child in range(first + 1, min(first + 4, size)):
            if keys[child] < keys[smallest_child]:
                smallest_child = child
        if keys[smallest_child] >= key:
            break
        heap[position], keys[position] = heap[smallest_child], keys[smallest_child]
        heap_position[heap[position]] = position
        position = smallest_child
    if size > 0:
        heap[position], keys[position], heap_position[node] = node, key, position
    return size


@part
def _insert_node(keys, heap, heap_position, size, node, key):  # type: ignore[no-untyped-def]
    """Insert a node into the heap or reduce its key, and return the new size."""
    position = heap_position[node]
    if position < 0:
        position, size = size, size + 1
        heap[position], heap_position[node] = node, position
    keys[position] = key
    _sift_up(keys, heap, heap_position, position)
    return size


@kernel(
    "b1(f8[:,::1], i8[::1], i4[::1], f8[::1], i8, i8, f8, "
    "f8[::1], i4[::1], f8[::1], i4[::1], i4[::1])"
)
def search_least_cost(  # type: ignore[no-untyped-def]
    positions,
    starts,
    neighbours,
    costs,
    start,
    end,
    min_cost,
    distance,
    predecessor,
    keys,
    heap,
    heap_position,
):
    """Search from one node to another (Dijkstra 1959), and return whether it is reached.

    The cost of an arc is its length times the mean cost per metre at its ends. If `min_cost`, a
    lower bound of this cost, is positive, the remaining distance guides the search (A*, Hart,
    Nilsson & Raphael 1968). `distance` must be infinite and `heap_position` -1 on entry; the
    predecessors are written to `predecessor`; `keys` and `heap` (n,) are work arrays.
    """
    distance[start], predecessor[start] = 0.0, -1
    size = _insert_node(keys, heap, heap_position, 0, start, 0.0)
    while size > 0:
        node = heap[0]
        if node == end:
            return True
        size = _remove_root(keys, heap, heap_position, size)
        base = distance[node]
        for k in range(starts[node], starts[node + 1]):
            neighbour = neighbours[k]
            # Coincident nodes are also connected by an arc.
            step = max(
                _distance(positions, node, neighbour) * 0.5 * (costs[node] + costs[neighbour]),
                1e-15,
            )
            total = base + step
            if total < distance[neighbour]:
                distance[neighbour] = total
                predecessor[neighbour] = node
                remaining_cost = (
                    min_cost * _distance(positions, neighbour, end) if min_cost > 0.0 else 0.0
                )
                size = _insert_node(
                    keys, heap, heap_position, size, neighbour, total + remaining_cost
                )
    return False


@part
def _find_slot(node, slots, nodes, count, headings, distance, heap_position):  # type: ignore[no-untyped-def]
    """Return the slot of a node, initialised on first use; -1 if `nodes` is full."""
    slot = slots[node]
    if slot >= 0 or count == len(nodes):
        return slot
    slots[node], nodes[count] = count, node
    for state in range(count * headings, (count + 1) * headings):
        distance[state], heap_position[state] = math.inf, -1
    return count


@kernel(
    "i8(f8[:,::1], f8[:,::1], i8[::1], i4[::1], f8[::1], i8, i8, f8[::1], f8, i8, f8, "
    "i4[::1], i4[::1], f8[::1], i4[::1], f8[::1], i4[::1], i4[::1])"
)
def search_least_turning(  # type: ignore[no-untyped-def]
    positions,
    plane_coordinates,
    starts,
    neighbours,
    costs,
    start,
    target,
    remaining_costs,
    turn_cost,
    headings,
    min_cosine,
    slots,
    nodes,
    distance,
    predecessor,
    keys,
    heap,
    heap_position,
):
    """Search over states, each of which is a node with one of `headings` directions.

    Arcs within an angle (cosine `min_cosine`) of the heading in `plane_coordinates` (n, 2) lead to
    the same heading at another node. Changing to the next heading on either side costs `turn_cost`.
    Return the state at the target, -1 if it is not connected, or -2 if `nodes` is full.

    `remaining_costs` (n,) is a lower bound of the cost from each node to the target. `slots` (n,)
    must be -1 on entry. State slot * headings + h belongs to nodes[slot]. The other arrays are work
    arrays.
    """
    count = _find_slot(start, slots, nodes, 0, headings, distance, heap_position) + 1
    size = 0
    for state in range(headings):
        distance[state], predecessor[state] = 0.0, -1
        size = _insert_node(keys, heap, heap_position, size, state, remaining_costs[start])
    while size > 0:
        state = heap[0]
        slot, h = state // headings, state % headings
        node = nodes[slot]
        if node == target:
            return state
        size = _remove_root(keys, heap, heap_position, size)
        base = distance[state]
        for side in (1, headings - 1):
            next_state = slot * headings + (h + side) % headings
            if base + turn_cost < distance[next_state]:
                distance[next_state] = base + turn_cost
                predecessor[next_state] = state
                size = _insert_node(
                    keys,
                    heap,
                    heap_position,
                    size,
                    next_state,
                    base + turn_cost + remaining_costs[node],
                )
        angle = 2.0 * math.pi * h / headings
        x, y = math.cos(angle), math.sin(angle)
        for k in range(starts[node], starts[node + 1]):
            end = neighbours[k]
            right, up = (
                plane_coordinates[end, 0] - plane_coordinates[node, 0],
                plane_coordinates[end, 1] - plane_coordinates[node, 1],
            )
            # An arc perpendicular to the plane has no direction within it.
            if right * x + up * y < min_cosine * math.sqrt(right * right + up * up):
                continue
            step = max(_distance(positions, node, end) * 0.5 * (costs[node] + costs[end]), 1e-15)
            end_slot = _find_slot(end, slots, nodes, count, headings, distance, heap_position)
            if end_slot < 0:
                return -2
            count = max(count, end_slot + 1)
            next_state = end_slot * headings + h
            if base + step < distance[next_state]:
                distance[next_state] = base + step
                predecessor[next_state] = state
                size = _insert_node(
                    keys, heap, heap_position, size, next_state, base + step + remaining_costs[end]
                )
    return -1
