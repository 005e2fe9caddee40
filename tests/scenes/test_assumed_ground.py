"""Claims where no floor is seen hold wherever the ground may lie, or are not made."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from clouds import level as sheet_at
from clouds import mug

from spherefunc_bullet.clouds.cloud import Cloud
from spherefunc_bullet.function_model import Membership
from spherefunc_bullet.scenes.recognition.judging import holding_anywhere


def by_height(clouds: list[Cloud]) -> list[dict[str, Membership]]:
    """Tell by the top's height alone: seats up to half a metre, tables from 0.6 to 1 m, cups whatever it is."""
    tops = [float(cloud.bounds[1, 2]) for cloud in clouds]
    return [
        {
            "cup": Membership(member=cloud.size.max() < 0.2, score=0.8, radius=0.01),
            "sittable": Membership(member=top < 0.5 and cloud.size.max() > 0.2, score=0.7, radius=0.03),
            "table": Membership(member=0.6 < top < 1.0, score=0.9, radius=0.03),
        }
        for cloud, top in zip(clouds, tops, strict=True)
    ]


def on_lower_ground(*clouds: Cloud) -> Callable[[Sequence[int], float], list[dict[str, Membership]]]:
    """Return what tells some of the clouds, by their places, on a ground that lies lower."""
    return lambda places, lower: by_height([Cloud(clouds[k].points + [0.0, 0.0, lower]) for k in places])


def kept(*clouds: Cloud) -> list[set[str]]:
    answer = holding_anywhere(clouds, by_height(list(clouds)), on_lower_ground(*clouds), 0.5)
    return [{name for name, membership in one.items() if membership.member} for one in answer]


def test_a_seat_that_a_lower_floor_would_make_a_table_is_not_claimed():
    seat, table = (Cloud(sheet_at(0.8, 0.6, height)[::8]) for height in (0.42, 0.72))
    assert kept(seat, table) == [set(), {"table"}]


def test_small_things_keep_their_claims_and_scores_stay():
    cup = Cloud(mug().points)
    assert kept(cup) == [{"cup"}]
    seat = Cloud(sheet_at(0.8, 0.6, 0.42)[::8])
    (answer,) = holding_anywhere([seat], by_height([seat]), on_lower_ground(seat), 0.5)
    assert answer["sittable"].score == 0.7


def test_nothing_is_asked_where_nothing_is_claimed():
    def refuse(places: Sequence[int], lower: float) -> list[dict[str, Membership]]:
        assert not len(places)
        return []

    high = Cloud(np.vstack([sheet_at(0.8, 0.6, 1.4)[::8]]))
    assert holding_anywhere([high], by_height([high]), refuse, 0.5) == by_height([high])
