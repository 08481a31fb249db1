#pragma once
// Three clients of the daemon, with the engines of its doors between them and the bench: two speak SCPI, one
// HTTP. No sockets.
#include <array>
#include <deque>
#include <functional>
#include <list>
#include <memory>
#include <string>

#include "daemon/remote/access/access.hpp"
#include "daemon/remote/instrument/instrument.hpp"
#include "daemon/remote/scpi/session.hpp"
#include "daemon/remote/web/actions.hpp"
#include "daemon/service/pending_orders.hpp"
#include "tests/orders/laws.hpp"
#include "tests/orders/plan.hpp"
#include "tests/orders/scpi_answers.hpp"

namespace shaker::orders {

class Clients {
public:
    Clients(service::BenchPort& port, Laws& laws);
    ~Clients();
    Clients(const Clients&) = delete;
    Clients& operator=(const Clients&) = delete;

    void act(const Move& move);
    /// Passes answers to the clients. Call it once a round.
    void turn();
    /// Reports each request that has been waiting for longer than `most_s`.
    void require_answers(double most_s);
    /// Remarks that the bench has accepted, with the virtual time at which it did, s.
    [[nodiscard]] const std::vector<std::pair<double, std::string>>& remarks() const noexcept {
        return remarks_;
    }

private:
    struct Request {
        std::string what;
        double since_s;
    };
    void say(int client, Action action, double value);
    void post(const std::string& name, const std::string& body, Action action);
    void send(std::size_t session, const std::string& text);
    void take_answers(std::size_t session);
    void open(std::size_t session);
    void reload(double value);
    void see_clears();

    service::BenchPort& port_;
    Laws& laws_;
    std::deque<std::function<void()>> later_{};
    service::PendingOrders pending_orders_;
    access::Aborts aborts_;
    access::ControlLock lock_{};
    access::Access access_{};
    scpi::DeviceStatus status_{};
    instrument::BenchInstrument instrument_;
    scpi::CommandTree tree_;
    std::array<std::unique_ptr<scpi::Session>, 2> sessions_{};
    std::array<int, 2> opened_{};
    std::array<ScpiAnswers, 2> answers_{};
    web::Actions actions_;
    std::list<Request> requests_{};  // over HTTP, without an answer
    std::vector<std::pair<double, std::string>> remarks_{};
    int remarked_ = 0, recorded_ = 0;
    std::uint64_t clears_ = 0;  // accepted, as logged
};

}  // namespace shaker::orders
