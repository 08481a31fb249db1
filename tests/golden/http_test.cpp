// Answers over HTTP, the state for the page and the metrics, to the byte.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <sstream>
#include <string>

#include "daemon/remote/web/metrics.hpp"
#include "daemon/remote/web/requests.hpp"
#include "daemon/remote/web/state_json.hpp"
#include "tests/fuzz/inline_bench.hpp"
#include "tests/support/golden.hpp"
#include "tests/support/run/bench_on_call.hpp"

namespace shaker::web {
namespace {

namespace http = boost::beast::http;

/// A bench that executes orders without devices, behind the answers to requests.
class Door {
public:
    explicit Door(const std::string& token) : token_{token} {}

    /// "> METHOD TARGET BODY", the fields of the request, the answer with its fields.
    std::string told(const std::string& line,
                     const std::vector<std::pair<std::string, std::string>>& fields) {
        std::istringstream words{line};
        std::string method, target, body, all = "> " + line + '\n';
        words >> method >> target >> std::ws;
        std::getline(words, body);
        Request request;
        request.method_string(method);
        request.target(target);
        request.version(11);
        request.set(http::field::host, "localhost");
        for (const auto& [field, value] : fields) {
            request.set(field, value);
            all.append("+ ").append(field).append(": ").append(value) += '\n';
        }
        request.body() = body;
        request.prepare_payload();
        return all + answered(request);
    }

private:
    std::string answered(const Request& request) {
        if (takes_socket(request, site_)) return "(the live socket)\n";
        std::optional<Response> response;
        answer(request, site_, client_of(request, "192.0.2.1"), [&](Response r) { response = std::move(r); });
        bench_.settle();
        site_.actions.update();
        if (!response) return "(no answer)\n";
        std::string text =
            std::to_string(response->result_int()) + ' ' + std::string{response->reason()} + '\n';
        for (const auto& field : *response)
            text += std::string{field.name_string()} + ": " + std::string{field.value()} + '\n';
        const bool json = (*response)[http::field::content_type] == "application/json";
        return text + (json ? test::by_keys(response->body()) : response->body());
    }

    std::string token_;
    test::InlineBench bench_;
    Site site_{.pending_orders = bench_.pending_orders,
               .lock = bench_.lock,
               .actions = Actions{bench_.pending_orders, bench_.lock, bench_.aborts},
               .access = {.hosts = {"localhost"}, .token = token_},
               .daemon = "0123456789abcdef",
               .page = {{"/", {"text/html; charset=utf-8", "the page\n"}}}};
};

// The lines "> METHOD TARGET BODY" of the kept text are sent with the fields "+ NAME: VALUE" behind them; a
// line
// "== title" begins with a bench of its own, which asks a token if the title names one.
TEST(GoldenHttpTest, AnswersOfEveryRoute) {
    const char* file = "http/answers.txt";
    const std::vector<std::string> lines = test::golden_inputs(file, {"== ", "> ", "+ "});
    std::string all;
    std::unique_ptr<Door> door;
    for (std::size_t i = 0; i < lines.size();) {
        const std::string& line = lines[i++];
        if (line.starts_with("== ")) {
            door = std::make_unique<Door>(line.find("token") != std::string::npos ? "0123456789abcdefghijkl"
                                                                                  : "");
            all += line + '\n';
            continue;
        }
        std::vector<std::pair<std::string, std::string>> fields;
        for (; i < lines.size() && lines[i].starts_with("+ "); ++i) {
            const std::size_t colon = lines[i].find(": ");
            fields.emplace_back(lines[i].substr(2, colon - 2), lines[i].substr(colon + 2));
        }
        if (door) all += door->told(line.substr(2), fields);
    }
    test::expect_golden(file, test::without_place_and_time(all));
}

class GoldenStateTest : public test::OnCallBench {
protected:
    /// Keeps the state of this moment, of the first with a result also the result and the metrics, then acts.
    std::function<void(service::BenchPort&)> kept(const char* moment,
                                                  std::function<void(service::BenchPort&)> act) {
        return [this, moment, act = std::move(act)](service::BenchPort& port) {
            const auto title = std::string{"== "} + moment + '\n';
            service::BenchState state = *port.state();
            state.recording.free_bytes = state.recording.room_bytes = 1e9;  // of this computer's disk
            states += title + test::by_keys(state_json(state, {"a page", true, false, "0123456789abcdef"}));
            if (state.result && results.empty()) {
                results = title + test::by_keys(result_json(state));
                metrics = title + metrics_text(&state, {});
            }
            act(port);
        };
    }
    std::string states, results, metrics;
};

// A run on virtual time: at rest, in a measurement, behind it, after an abort.
TEST_F(GoldenStateTest, StateResultMetricsAndLogOfARun) {
    using run::RunState;
    options.pictures = recorded::KeptPictures::off;
    const auto nothing = [](service::BenchPort&) {};
    const auto r =
        play(test::slow,
             {{test::in(RunState::idle), kept("idle", give(service::Begin{{.periods = 10}}))},
              {test::in(RunState::run), kept("run", nothing)},
              {test::measured(1), kept("measured", [](service::BenchPort& port) { port.abort("a test"); })},
              {test::may_clear, kept("tripped", give(service::ClearTrip{}))},
              {test::in(RunState::idle), kept("cleared", nothing)}},
             60, {0.113, 0.001});
    test::expect_golden("http/state.txt", test::without_place_and_time(states, folder));
    test::expect_golden("http/result.txt", test::without_place_and_time(results, folder));
    test::expect_golden("http/metrics.txt", test::without_place_and_time(metrics, folder));
    test::expect_golden("http/log.txt", test::without_place_and_time(test::log_of(r), folder));
}

}  // namespace
}  // namespace shaker::web
