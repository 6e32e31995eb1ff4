"""Seats of a class: the same for a browser that comes back, few, and forgotten when it ends."""

from app.audience.seats import SHAPES, Seat, Seats


def sat(seats: Seats, ticket: str) -> Seat:
    seat = seats.sit(ticket)
    assert seat is not None
    return seat


def test_a_ticket_has_a_seat_from_its_first_page_on() -> None:
    seats = Seats()
    tickets = [seats.new_ticket() for _ in range(20)]
    assert seats.all == ()
    taken = [sat(seats, ticket) for ticket in tickets]
    assert [seat.number for seat in taken] == list(range(1, 21))
    assert {seat.shape for seat in taken} == set(SHAPES)
    assert seats.all == tuple(taken)


def test_who_comes_back_has_the_same_and_two_pages_have_one() -> None:
    seats = Seats()
    ticket = seats.new_ticket()
    seat = sat(seats, ticket)
    assert sat(seats, ticket) is seat
    assert seat.n_pages == 2
    seats.leave(seat)
    seats.leave(seat)
    sat(seats, seats.new_ticket())
    assert sat(seats, ticket) is seat


def test_what_was_not_given_out_is_no_ticket() -> None:
    seats = Seats()
    ticket = seats.new_ticket()
    changed = [ticket[:-1], f"{ticket}0", ticket[1:] + ticket[0], "0" * 16 + ticket[16:]]
    for text in (*changed, "", "x", "é" * 80, "f" * 10_000, Seats().new_ticket()):
        assert not seats.is_ticket(text)
        assert seats.sit(text) is None
    assert seats.all == ()


def test_there_are_no_more_than_so_many_and_those_who_left_make_room() -> None:
    seats = Seats(most=3)
    tickets = [seats.new_ticket() for _ in range(4)]
    first, second, third = [sat(seats, ticket) for ticket in tickets[:3]]
    assert seats.sit(tickets[3]) is None
    seats.leave(second)
    fourth = sat(seats, tickets[3])
    assert fourth.number == 2
    assert not second.is_taken
    assert first.is_taken
    assert third.is_taken
    # Their ticket is good, but there is no seat any more.
    assert seats.sit(tickets[1]) is None
    assert len(seats.all) == 3


def test_what_is_forgotten_does_not_come_back() -> None:
    seats = Seats()
    ticket, unused = seats.new_ticket(), seats.new_ticket()
    seat = sat(seats, ticket)
    seats.forget()
    assert not seat.is_taken
    assert seats.all == ()
    assert not seats.is_ticket(ticket)
    assert seats.sit(ticket) is None
    assert seats.sit(unused) is None
    assert sat(seats, seats.new_ticket()).number == 1
