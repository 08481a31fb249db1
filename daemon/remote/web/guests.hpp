#pragma once
// Guests: connections that can be closed to admit a new one, so that one client with many connections blocks
// nobody.
#include <algorithm>
#include <functional>
#include <list>
#include <utility>

namespace shaker::web {

/// In order of the last complete request, or of arrival.
class Guests {
    struct Guest {
        std::function<void()> leave;
        bool asked = false;
    };

public:
    using Place = std::list<Guest>::iterator;

    /// leave: ends the connection soon; called at most once.
    Place enter(std::function<void()> leave) { return list_.insert(list_.end(), Guest{std::move(leave)}); }
    void heard(Place place) { list_.splice(list_.end(), list_, place); }
    void gone(Place place) { list_.erase(place); }
    /// Closes the connection with the longest silence. False when every connection is being closed already.
    bool ask_one_to_leave() {
        const auto first = std::ranges::find(list_, false, &Guest::asked);
        if (first == list_.end()) return false;
        first->asked = true;
        first->leave();
        return true;
    }

private:
    std::list<Guest> list_;
};

}  // namespace shaker::web
