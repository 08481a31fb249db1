#pragma once
// Actions: orders by POST /api/<name>. Converts JSON to orders and refusals to answers.
#include <functional>
#include <string>

#include "daemon/remote/access/control_lock.hpp"
#include "daemon/service/pending_orders.hpp"

namespace shaker::web {

/// An answer over HTTP: 200 {"ok":true}, or 4xx {"error":...}.
struct Answer {
    int status = 200;
    std::string json;
};

class Actions {
public:
    Actions(service::PendingOrders& pending_orders, access::ControlLock& lock)
        : pending_orders_{pending_orders}, lock_{lock} {}
    /// name: "drive"; who: the client, for control and the log. done: called once, at once or later. An abort
    /// is complete when this returns, for any client.
    void act(const std::string& name, const std::string& body, const std::string& who,
             const std::function<void(Answer)>& done);

private:
    service::PendingOrders& pending_orders_;
    access::ControlLock& lock_;
};

Answer refusal(int status, const std::string& why);

}  // namespace shaker::web
