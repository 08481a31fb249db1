#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "daemon/remote/access/server_clock.hpp"
#include "daemon/remote/server.hpp"
#include "daemon/remote/web/metrics.hpp"
#include "daemon/remote/web/state_json.hpp"
#include "daemon/service/published.hpp"
#include "tests/support/program.hpp"
#include "tests/support/remote/played_bench.hpp"
#include "tests/support/remote/socket_client.hpp"
#include "tests/support/remote/tcp_client.hpp"
#include "tests/support/remote/web_bench.hpp"

namespace shaker::remote {
namespace {

using nlohmann::json;
using test::Got;
using test::PlayedBench;
using test::TcpClient;

class WebTest : public test::WebBench {};

TEST_F(WebTest, PageHasStrictContentPolicy) {
    const Got got = request("GET /");
    EXPECT_EQ(got.status, 200);
    EXPECT_NE(got.body.find("the page"), std::string::npos);
    EXPECT_NE(got.head.find("Content-Security-Policy: default-src 'self'"), std::string::npos) << got.head;
    EXPECT_EQ(request("GET /../../etc/passwd").status, 404);
    EXPECT_EQ(request("GET /favicon.ico").status, 204);
}

TEST_F(WebTest, MetricsAndHealthReportState) {
    const Got metrics = request("GET /metrics");
    EXPECT_EQ(metrics.status, 200);
    EXPECT_NE(metrics.body.find("shakerd_state{state=\"idle\"} 1\n"), std::string::npos) << metrics.body;
    EXPECT_EQ(request("GET /healthz").status, 200);
    EXPECT_EQ(request("GET /readyz").status, 200);
    bench.bench_port.abort("a test");
    for (int i = 0; i < 200 && request("GET /healthz").status == 200; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds{5});
    EXPECT_EQ(request("GET /healthz").status, 503);
}

TEST_F(WebTest, MetricsAndStateReportRefusedRealTime) {
    const std::string metrics = request("GET /metrics").body;
    EXPECT_NE(metrics.find("shakerd_realtime{what=\"memory\"} 1\n"), std::string::npos) << metrics;
    EXPECT_NE(metrics.find("shakerd_realtime{what=\"output\"} 0\n"), std::string::npos) << metrics;
    const json grants = json::parse(request("GET /api/state").body).at("real_time");
    ASSERT_EQ(grants.size(), 2U);
    EXPECT_TRUE(grants[0].at("refused").is_null());
    EXPECT_EQ(grants[1].at("refused"), "output: cannot set real-time priority 70");
}

TEST_F(WebTest, MetricsAndStateReportContactAndEnable) {
    const std::string metrics = request("GET /metrics").body;
    EXPECT_NE(metrics.find("shakerd_abort_contact{state=\"open\"} 1\n"), std::string::npos) << metrics;
    EXPECT_NE(metrics.find("shakerd_abort_contact{state=\"closed\"} 0\n"), std::string::npos) << metrics;
    EXPECT_NE(metrics.find("shakerd_enable_output 1\n"), std::string::npos) << metrics;
    const json switches = json::parse(request("GET /api/state").body).at("switches");
    EXPECT_EQ(switches.at("abort_contact"), "open");
    EXPECT_EQ(switches.at("enable_output"), true);
}

TEST_F(WebTest, MetricsCountScpiErrors) {
    TcpClient client{server.scpi_port()};
    for (int i = 0; i < 3; ++i) client.send("NO:SUCH:HEADER");
    EXPECT_EQ(client.ask("*IDN?").substr(0, 7), "shakerd");
    std::string metrics;
    for (int i = 0; i < 100 && metrics.find("shakerd_scpi_errors_total 3\n") == std::string::npos; ++i)
        metrics = request("GET /metrics").body;
    EXPECT_NE(metrics.find("shakerd_scpi_errors_total 3\n"), std::string::npos) << metrics;
    EXPECT_NE(metrics.find("shakerd_scpi_messages_total 4\n"), std::string::npos) << metrics;
}

TEST_F(WebTest, SocketGetsPointsAtStartAndAfterMeasurements) {
    test::SocketClient page{server.http_port(), "/ws?client=tab1"};
    const auto next_has_points = [&page] {
        for (;;) {
            const auto message = page.next();
            if (message.op < 0) throw std::runtime_error{"nothing came"};
            const json text = json::parse(message.data);
            if (text["type"] == "state") return text.contains("points");
        }
    };
    EXPECT_TRUE(next_has_points());
    for (int i = 0; i < 5; ++i) EXPECT_FALSE(next_has_points());
    EXPECT_EQ(post("start", "").status, 200);  // the played bench has its result at once
    int told = 0;
    for (int i = 0; i < 10; ++i) told += next_has_points() ? 1 : 0;
    EXPECT_EQ(told, 1);
    EXPECT_TRUE(json::parse(request("GET /api/state").body).contains("points"));
}

TEST_F(WebTest, ResultsAreServedAndPushedOnce) {
    catalogue::ResultRow row;
    row.time = "2026-11-26T10:00:00Z";
    row.v_D = {0.0066, 1e-6};
    bench.bench_port.results().add({row});
    const json all = json::parse(request("GET /api/results").body);
    ASSERT_EQ(all["results"].size(), 1U);
    EXPECT_EQ(all["results"][0]["v_D_mps"]["value"], 0.0066);
    EXPECT_EQ(all["results"][0]["asked"], nullptr);
    EXPECT_EQ(json::parse(request("GET /api/repeats").body)["repeats"].size(), 0U) << "no set-point is known";
    const Got csv = request("GET /api/results.csv");
    EXPECT_NE(csv.head.find("text/csv"), std::string::npos);
    EXPECT_NE(csv.body.find("\r\n2026-11-26T10:00:00Z,"), std::string::npos) << csv.body;

    test::SocketClient page{server.http_port(), "/ws?client=tab1"};
    const auto next_rows = [&page] {
        for (;;) {
            const auto message = page.next();
            if (message.op < 0) throw std::runtime_error{"nothing came"};
            const json text = json::parse(message.data);
            if (text["type"] == "results") return text["results"];
        }
    };
    EXPECT_EQ(next_rows(), all["results"]) << "those of before, at the start";
    row.time = "2026-11-26T10:00:05Z";
    bench.bench_port.results().add({row});
    const json added = next_rows();
    ASSERT_EQ(added.size(), 1U) << "only the new one";
    EXPECT_EQ(added[0]["id"], 2);
}

TEST_F(WebTest, OtherSitesAndNamesAreRefused) {
    EXPECT_EQ(request("GET /api/state", {}, {}, "evil.example").status, 403);
    EXPECT_EQ(request("POST /api/abort", {}, "Origin: http://evil.example\r\n").status, 403);
    EXPECT_EQ(bench.aborts, 0);
    EXPECT_EQ(request("POST /api/abort", {}, "Origin: http://localhost\r\n").status, 200);
}

TEST_F(WebTest, BadRequestEndsOnlyItsConnection) {
    TcpClient babbler{server.http_port()};
    babbler.send_bytes(std::string(100000, 'x'));
    EXPECT_TRUE(babbler.closed());
    TcpClient slow{server.http_port()};
    slow.send_bytes("GET / HT");
    EXPECT_EQ(post("drive", std::string(70000, ' ')).status, 0);
    EXPECT_EQ(request("GET /").status, 200);
}

TEST(StateJsonTest, ResultHasItsMeasurement) {
    service::BenchState state;
    EXPECT_TRUE(json::parse(web::state_json(state, {}))["result"]["age_s"].is_null());
    auto result = std::make_shared<reduction::Reduction>();
    result->v_D = {0.0145, 3e-5};
    result->stick = {{0.5, 0.7, 0.01}};
    result->shortest_visible_stick = 0.03;
    state.result = result;
    state.result_origin = {.number = 7, .asked = state.wanted, .from_s = 10, .to_s = 12};
    state.now_s = 15;
    const json now = json::parse(web::state_json(state, {}))["result"];
    EXPECT_EQ(now["number"], 7);
    EXPECT_EQ(now["age_s"], 3);
    EXPECT_EQ(now["stick"], json::array({{0.5, 0.7}}));
    EXPECT_EQ(now["shortest_visible_stick"], 0.03);
    EXPECT_EQ(now["drive"]["gamma_mps2"], state.wanted.gamma);
    EXPECT_EQ(now["current"], true);
    state.wanted.phi = 1;
    EXPECT_EQ(json::parse(web::state_json(state, {}))["result"]["current"], false);
    const json fetched = json::parse(web::result_json(state))["measurement"];
    EXPECT_EQ(fetched["number"], 7);
    EXPECT_EQ(fetched["current"], false);
}

TEST(StateTextsTest, SocketsShareATextUntilItsStateIsOld) {
    web::StateTexts texts;
    service::BenchState state;
    const auto text = [&](const web::Viewer& viewer) {
        return texts.of(std::make_shared<const service::BenchState>(state), viewer);
    };
    const auto first = text({"tab1"});
    for (int page = 0; page < 24; ++page) EXPECT_EQ(text({"tab1"}), first) << "made once for all pages";
    EXPECT_EQ(*first, web::state_json(state, {"tab1"}));
    EXPECT_NE(*text({"tab1", true}), *first) << "the holder has a text of its own";
    EXPECT_NE(*text({"tab2"}), *first) << "control went to another";
    const auto at_rest = text({"tab2"});
    ++state.answered;
    EXPECT_NE(text({"tab2"}), at_rest) << "an answered order is shown at once";
    const auto answered = text({"tab2"});
    state.now_s = 7;
    EXPECT_EQ(text({"tab2"}), answered);
    access::ServerClock::advance(std::chrono::milliseconds{40});
    EXPECT_NE(text({"tab2"}), answered) << "a state is shown after 33 ms at the latest";
}

TEST(StateJsonTest, WalkerHasTheEndsOfItsPicture) {
    service::BenchState state;
    state.walker = {.x_m = 0.0225, .edge_m = 0.0075, .left_m = 0, .right_m = 0.128, .drift_m = {}, .lost = 0};
    const json walker = json::parse(web::state_json(state, {}))["walker"];
    EXPECT_EQ(walker["x_m"], 0.0225);
    EXPECT_EQ(walker["left_m"], 0);
    EXPECT_EQ(walker["right_m"], 0.128);
    state.walker->left_m = state.walker->right_m = NAN;
    EXPECT_TRUE(json::parse(web::state_json(state, {}))["walker"]["left_m"].is_null());
}

TEST(StateJsonTest, CamerasHaveGeometryAndFigures) {
    service::BenchFacts facts;
    facts.views = {
        {.camera = "top", .mm_per_px = 0.125, .targets = {{.name = "walker", .roi_px = {10, 20, 30, 40}}}},
        {.camera = "side", .targets = {}}};
    auto frame = std::make_shared<Frame>();
    frame->width = 64;
    frame->height = 1;
    frame->pixels.assign(64, std::byte{255});
    service::BenchState state;
    state.facts = std::make_shared<const service::BenchFacts>(facts);
    state.pictures_now = {{.camera = "top", .frame = frame, .fixes = {}, .targets = {}}};
    const json all = json::parse(web::state_json(state, {}))["cameras"];
    ASSERT_EQ(all.size(), 2U);
    EXPECT_EQ(all[0]["width_px"], 64);
    EXPECT_EQ(all[0]["mm_per_px"], 0.125);
    EXPECT_EQ(all[0]["clipped"], 1);
    EXPECT_TRUE(all[0]["edge_px"].is_null());
    EXPECT_EQ(all[0]["targets"], json::parse(R"([{"name": "walker", "region_px": [10, 20, 30, 40],
                                                 "proposed_px": null}])"));
    EXPECT_TRUE(all[1]["width_px"].is_null()) << "no picture yet";
    EXPECT_TRUE(all[1]["clipped"].is_null());
}

TEST_F(WebTest, MetricsFollowTheAskedFormat) {
    const Got plain = request("GET /metrics");
    EXPECT_NE(plain.head.find("text/plain; version=0.0.4"), std::string::npos);
    EXPECT_NE(plain.body.find("# TYPE shakerd_trips_total counter\n"), std::string::npos);
    EXPECT_EQ(plain.body.find("# EOF"), std::string::npos);
    const Got open = request("GET /metrics", {}, "Accept: application/openmetrics-text; version=1.0.0\r\n");
    EXPECT_NE(open.head.find("application/openmetrics-text; version=1.0.0"), std::string::npos);
    EXPECT_NE(open.body.find("# TYPE shakerd_trips counter\nshakerd_trips_total "), std::string::npos);
    EXPECT_TRUE(open.body.ends_with("# EOF\n"));
}

TEST_F(WebTest, LawIsComputedBesideTheServer) {
    EXPECT_EQ(json::parse(request("GET /api/law").body), json::parse(R"({"mu":null})"));
    EXPECT_EQ(post("drive", R"({"frequency_hz":20,"gamma_mps2":9.8,"rho":0.5,"phi_rad":0})").status, 200);
    EXPECT_EQ(post("mu", R"({"mu":0.113,"sigma":0.005})").status, 200);
    Got got;
    for (int i = 0; i < 1000 && got.status != 200; ++i) {
        got = request("GET /api/law");
        ASSERT_TRUE(got.status == 200 || got.status == 202) << got.body;
        std::this_thread::sleep_for(std::chrono::milliseconds{20});
    }
    const json law = json::parse(got.body);
    EXPECT_EQ(law["mu"], 0.113);
    EXPECT_EQ(law["phi"]["phi_rad"].size(), law["phi"]["exact_mps"]["high"].size());
    EXPECT_DOUBLE_EQ(law["gamma"]["gamma_mps2"].back(), 3 * paper_g);
    EXPECT_NEAR(law["gamma"]["exact_mps"]["at_mu"].back(), 56.8514e-3, 1e-7);
    EXPECT_EQ(request("GET /api/law").status, 200) << "kept";
}

TEST_F(WebTest, PicturesOfATripAreServed) {
    EXPECT_EQ(request("GET /api/trip/pictures/0").status, 404);
    EXPECT_EQ(post("abort", "").status, 200);
    const Got got = request("GET /api/trip/pictures/0");
    EXPECT_EQ(got.status, 200);
    EXPECT_GT(got.body.size(), 40U);
    EXPECT_EQ(got.body.substr(0, 4), "1DKS") << "as a live picture";
    EXPECT_EQ(json::parse(request("GET /api/state").body)["session"]["trip"]["pictures"], 1);
    EXPECT_EQ(request("GET /api/trip/pictures/1").status, 404);
}

TEST(PublishedTest, EveryQuantityIsAtItsPlaceInStateAndMetrics) {
    service::BenchState state;
    state.base.emplace();
    state.walker.emplace();
    state.result = std::make_shared<const reduction::Reduction>();
    state.tracking.emplace();
    state.campaign.emplace();
    state.enable_output = true;
    const json all = json::parse(web::state_json(state, {}));
    const std::string metrics = web::metrics_text(&state, {});
    for (const service::Published& row : service::published_quantities()) {
        EXPECT_TRUE(row.json != nullptr || row.header != nullptr || row.metric != nullptr) << row.help;
        if (row.json != nullptr) {
            EXPECT_TRUE(all.contains(json::json_pointer{row.json})) << row.json;
        }
        if (row.metric == nullptr) continue;
        const std::string name = std::string{"shakerd_"} + row.metric;
        EXPECT_NE(metrics.find("# HELP " + name + ' ' + row.help + '\n'), std::string::npos) << name;
        EXPECT_NE(metrics.find('\n' + name + ' '), std::string::npos) << name;
    }
    EXPECT_EQ(all["switches"]["enable_output"], true);
    const json unknown = json::parse(web::state_json({}, {}));
    EXPECT_TRUE(unknown["walker"].is_null());
    EXPECT_TRUE(unknown["measured"]["rms_mps2"].is_null());
    service::BenchState bare;
    EXPECT_EQ(web::metrics_text(&bare, {}).find("shakerd_walker_position_metres"), std::string::npos);
}

TEST(WebTokenTest, OnlyAnAbortIsAllowedWithoutToken) {
    PlayedBench bench;
    Server server{bench.bench_port, {.http_port = 0, .scpi_port = 0, .token = "0123456789abcdefghijklmn"}};
    const auto status = [&](const std::string& action, const std::string& more) {
        TcpClient client{server.http_port()};
        client.send_bytes("POST /api/" + action + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" +
                          more + "Content-Length: 0\r\n\r\n");
        return client.rest().substr(9, 3);
    };
    EXPECT_EQ(status("stop", ""), "401");
    EXPECT_EQ(status("stop", "X-Shaker-Token: 0123456789abcdefghijklm\r\n"), "401");
    EXPECT_TRUE(bench.ordered().empty());
    EXPECT_EQ(status("stop", "X-Shaker-Token: 0123456789abcdefghijklmn\r\n"), "200");
    EXPECT_EQ(bench.ordered().size(), 1U);
    EXPECT_EQ(status("abort", ""), "200");
    EXPECT_EQ(status("abort", "Origin: http://elsewhere.example\r\n"), "403");
    EXPECT_EQ(bench.aborts, 1);
}

}  // namespace
}  // namespace shaker::remote
