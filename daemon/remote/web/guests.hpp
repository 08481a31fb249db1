#pragma once
// Connections that may be asked to leave for a new one: whoever holds many open keeps nobody else out.
#include <algorithm>
#include <functional>
#include <list>
#include <utility>

namespace shaker::web {

/// In order of when they last sent a whole request, or came.
class Guests {
    struct Guest {
        std::function<void()> leave;
        bool asked = false;
    };

public:
    using Place = std::list<Guest>::iterator;

    /// leave: ends the connection soon; called once at most.
    Place enter(std::function<void()> leave) { return list_.insert(list_.end(), Guest{std::move(leave)}); }
    void heard(Place place) { list_.splice(list_.end(), list_, place); }
    void gone(Place place) { list_.erase(place); }
    /// Asks the one that was silent for the longest. False: nobody is left to ask.
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
