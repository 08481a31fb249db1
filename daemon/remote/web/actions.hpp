#pragma once
// Actions: orders by POST /api/<name>. Converts JSON to orders and refusals to answers.
#include <functional>
#include <list>
#include <string>

#include "daemon/remote/access/access.hpp"
#include "daemon/service/pending_orders.hpp"

namespace shaker::web {

/// An answer over HTTP: 200 {"ok":true}, or 4xx and 5xx {"error":...}.
struct Answer {
    int status = 200;
    std::string json;
};

class Actions {
public:
    using Done = std::function<void(Answer)>;
    Actions(service::PendingOrders& pending_orders, access::ControlLock& lock, access::Aborts& aborts)
        : pending_orders_{pending_orders}, lock_{lock}, aborts_{aborts} {}
    /// name: "drive"; who: the client, for control and the log. done: called once, at once or later.
    void act(const std::string& name, const std::string& body, const std::string& who, const Done& done);
    /// Stops the drive at once, for any client. done: called once the output has obeyed, or with 504 when it
    /// did not in time; it may be empty.
    void abort(const std::string& who, Done done);
    /// Answers aborts. Call it often.
    void update();

private:
    service::PendingOrders& pending_orders_;
    access::ControlLock& lock_;
    access::Aborts& aborts_;
    struct Unanswered {
        access::Aborts::Receipt receipt;
        Done done;
    };
    std::list<Unanswered> unanswered_{};
};

Answer refusal(int status, const std::string& why);

}  // namespace shaker::web
