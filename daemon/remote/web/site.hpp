#pragma once
// What all connections of browsers and scripts share.
#include <map>
#include <string>

#include "daemon/remote/web/access.hpp"
#include "daemon/remote/web/actions.hpp"
#include "daemon/remote/web/guests.hpp"
#include "daemon/remote/web/metrics.hpp"

namespace shaker::web {

/// A file of the page.
struct PageFile {
    std::string type;  // "text/html; charset=utf-8"
    std::string content;
};

/// One thread.
struct Site {
    OrderBook& book;
    scpi::ControlLock& lock;
    Actions actions;
    Access access;
    std::map<std::string, PageFile> page;  // by path: "/"
    ServedCounts served{};
    std::map<std::string, int> sockets{};  // of each client that may hold control
    Guests guests{};                       // connections without a socket
    int live_clients = 0;                  // connections with one: these stay
    int most_clients = 32;
    int most_live = 24;  // the others are for requests, an abort among them
};

}  // namespace shaker::web
