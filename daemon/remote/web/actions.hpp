#pragma once
// What a page or a script may order by POST /api/<name>: JSON to orders, and back why not.
#include <functional>
#include <string>

#include "daemon/order_book.hpp"
#include "daemon/remote/scpi/control_lock.hpp"

namespace shaker::web {

/// An answer over HTTP: 200 {"ok":true}, or 4xx {"error":...}.
struct Answer {
    int status = 200;
    std::string json;
};

class Actions {
public:
    Actions(OrderBook& book, scpi::ControlLock& lock) : book_{book}, lock_{lock} {}
    /// name: "drive"; who: the client, for control and the log. done is called once, later or at once; an
    /// abort is done when this returns, whoever asks.
    void act(const std::string& name, const std::string& body, const std::string& who,
             const std::function<void(Answer)>& done);

private:
    OrderBook& book_;
    scpi::ControlLock& lock_;
};

Answer refusal(int status, const std::string& why);

}  // namespace shaker::web
