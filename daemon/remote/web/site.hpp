#pragma once
// Site: objects shared by all connections of browsers and scripts.
#include <algorithm>
#include <functional>
#include <list>
#include <map>
#include <string>
#include <utility>

#include "daemon/catalogue/catalogue.hpp"
#include "daemon/remote/access/access.hpp"
#include "daemon/remote/access/server_clock.hpp"
#include "daemon/remote/web/actions.hpp"
#include "daemon/remote/web/law_answer.hpp"
#include "daemon/remote/web/metrics.hpp"
#include "daemon/remote/web/page_files.hpp"
#include "daemon/remote/web/state_json.hpp"

namespace shaker::web {

/// Connections that can be closed to admit a new one, so that one client with many connections blocks nobody.
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

/// One thread.
struct Site {
    service::PendingOrders& pending_orders;
    access::ControlLock& lock;
    Actions actions;
    access::Access access;
    std::string daemon{};                        // identity of this start of the daemon
    std::map<std::string, PageFile> page;        // by path: "/"
    catalogue::Catalogue* recordings = nullptr;  // null: none is served
    ServedCounts served{};
    LawAnswer law{};
    StateTexts state_texts{};
    std::map<std::string, int> sockets{};  // number of sockets of each client that may hold control
    Guests guests{};                       // connections without a socket
    int downloads = 0;                     // of recordings, at most most_downloads
    int live_clients = 0;                  // connections with a socket; these are kept
    int most_clients = 32;
    int reserve = 64;  // further connections, which have a moment for a request, such as an abort
    int most_downloads = 4;
    int most_live = 24;  // leaves connections free for requests, such as an abort
};

}  // namespace shaker::web
