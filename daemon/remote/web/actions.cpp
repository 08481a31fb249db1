#include "daemon/remote/web/actions.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "daemon/remote/web/order_fields.hpp"
#include "drivers/errors.hpp"

namespace shaker::web {

namespace {

using nlohmann::json;

constexpr int bad_request = 400, not_found = 404, conflict = 409, gateway_timeout = 504;
const Answer well{200, R"({"ok":true})"};

}  // namespace

Answer refusal(int status, const std::string& why) {
    return {status, json{{"error", why}}.dump(-1, ' ', false, json::error_handler_t::replace)};
}

void Actions::abort(const std::string& who, Done done) {
    access::Aborts::Receipt receipt = aborts_.give(who);
    if (done) unanswered_.push_back({std::move(receipt), std::move(done)});
}

void Actions::update() {
    using access::Aborts;
    for (auto u = unanswered_.begin(); u != unanswered_.end();) {
        const Aborts::Answer answer = u->receipt();
        if (answer == Aborts::Answer::none) {
            ++u;
            continue;
        }
        const Done done = std::move(u->done);
        u = unanswered_.erase(u);
        done(answer == Aborts::Answer::obeyed ? well : refusal(gateway_timeout, Aborts::silent_text));
    }
}

void Actions::act(const std::string& name, const std::string& body, const std::string& who,
                  const Done& done) {
    if (name == "abort") return abort(who, done);
    const auto held = [&] { return refusal(conflict, access::held_text(lock_.owner())); };
    try {
        if (name == "control/release" || name == "control/request") {
            require_no_fields(body);
            if (name == "control/request") return done(lock_.request(who) ? well : held());
            lock_.release(who);
            return done(well);
        }
        const orders::Row* row = orders::find(name);
        if (row == nullptr) return done(refusal(not_found, "there is no action \"" + name + "\""));
        const service::OrderWhat order = order_of(*row, body, pending_orders_.settings());
        if (!lock_.allows(who)) return done(held());
        pending_orders_.order(order, who, [done](const std::string& refused) {
            done(refused.empty() ? well : refusal(conflict, refused));
        });
    } catch (const InputError& e) {
        done(refusal(bad_request, e.what()));
    }
}

}  // namespace shaker::web
