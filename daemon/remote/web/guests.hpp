#pragma once
// Guests: connections that can be closed to admit a new one, so that one client with many connections blocks
// nobody.
#include <algorithm>
#include <functional>
#include <list>
#include <utility>

#include "daemon/remote/access/server_clock.hpp"

namespace shaker::web {

/// In order of the last complete request, or of arrival.
class Guests {
    struct Guest {
        std::function<void()> leave;
        access::ServerClock::time_point heard = access::ServerClock::now();
        bool asked = false;
    };

public:
    using Place = std::list<Guest>::iterator;

    /// leave: ends the connection soon; called at most once.
    Place enter(std::function<void()> leave) { return list_.insert(list_.end(), Guest{std::move(leave)}); }
    void heard(Place place) {
        place->heard = access::ServerClock::now();
        list_.splice(list_.end(), list_, place);
    }
    void gone(Place place) { list_.erase(place); }
    /// Closes the connection with the longest silence, if that is at least `silence`. False when there is
    /// none.
    bool ask_one_to_leave(std::chrono::milliseconds silence) {
        const auto first = std::ranges::find(list_, false, &Guest::asked);
        if (first == list_.end() || access::ServerClock::now() - first->heard < silence) return false;
        first->asked = true;
        first->leave();
        return true;
    }
    /// Connections that are being closed.
    [[nodiscard]] int leaving() const noexcept {
        return static_cast<int>(std::ranges::count(list_, true, &Guest::asked));
    }

private:
    std::list<Guest> list_;
};

}  // namespace shaker::web
