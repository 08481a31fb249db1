#pragma once
// Site: objects shared by all connections of browsers and scripts.
#include <map>
#include <string>

#include "daemon/catalogue/catalogue.hpp"
#include "daemon/remote/access/access.hpp"
#include "daemon/remote/web/actions.hpp"
#include "daemon/remote/web/guests.hpp"
#include "daemon/remote/web/law_answer.hpp"
#include "daemon/remote/web/metrics.hpp"
#include "daemon/remote/web/page_files.hpp"

namespace shaker::web {

/// One thread.
struct Site {
    service::PendingOrders& pending_orders;
    access::ControlLock& lock;
    Actions actions;
    access::Access access;
    std::map<std::string, PageFile> page;        // by path: "/"
    catalogue::Catalogue* recordings = nullptr;  // null: none is served
    ServedCounts served{};
    LawAnswer law{};
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
