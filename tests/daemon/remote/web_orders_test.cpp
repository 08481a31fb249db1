// Orders over HTTP: their keys, numbers and refusals; aborts.
#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <thread>

#include "tests/support/remote/tcp_client.hpp"
#include "tests/support/remote/web_bench.hpp"

namespace shaker::remote {
namespace {

using nlohmann::json;
using test::Got;
using test::TcpClient;

class WebOrdersTest : public test::WebBench {};

TEST_F(WebOrdersTest, ACampaignIsAPlanOrAScan) {
    EXPECT_EQ(post("campaign", R"({"plan": "fig3"})").status, 200);
    EXPECT_EQ(post("campaign", R"({"scan": "phi", "from": 0, "to": 3, "steps": 6, "periods": 12})").status,
              200);
    const auto scan = std::get<service::MeasurePlan>(bench.ordered().back());
    EXPECT_EQ(scan.name, "scan");
    for (const char* part : {"phi = {from = 0, to = 3, steps = 6}", "gamma = 9.8", "periods = 12"})
        EXPECT_NE(scan.text.find(part), std::string::npos) << scan.text;
    EXPECT_EQ(post("campaign/skip", "").status, 200);
    EXPECT_EQ(std::get<service::TellCampaign>(bench.ordered().back()).word, campaign::Word::skip);
    EXPECT_EQ(post("campaign/go", "").status, 404);
    EXPECT_EQ(post("campaign/check", R"({"scan": "gamma", "from": 5, "to": 9, "steps": 2})").status, 200);
    EXPECT_EQ(std::get<service::CheckPlan>(bench.ordered().back()).name, "scan");
    EXPECT_EQ(post("campaign/check", "{}").status, 400);
    const json check = json::parse(request("GET /api/state").body).at("plan_check");
    EXPECT_EQ(check.at("fit"), 11);
    EXPECT_EQ(check.at("misfits").size(), 1U);
    const auto refused = [&](const std::string& body, const char* words) {
        const Got got = post("campaign", body);
        EXPECT_EQ(got.status, 400) << body;
        EXPECT_NE(got.body.find(words), std::string::npos) << got.body;
    };
    refused("{}", "either plan");
    refused(R"({"plan": "fig3", "scan": "phi"})", "either plan");
    refused(R"({"scan": "rho"})", "expected");
    refused(R"({"scan": "phi", "to": 3, "steps": 6})", "from: missing");
    refused(R"({"scan": "phi", "from": 0, "to": 3, "steps": 0})", "steps 0: expected a whole number from 1 to 1000");
    refused(R"({"plan": 7})", "plan 7: expected a string");
}

TEST_F(WebOrdersTest, ActionsAreOrdersAndRefusalsHaveReasons) {
    EXPECT_EQ(post("drive", R"({"gamma_mps2": 12, "phi_rad": 0.5})").status, 200);
    const json state = json::parse(request("GET /api/state").body);
    EXPECT_EQ(state["drive"]["gamma_mps2"], 12);
    EXPECT_EQ(state["drive"]["frequency_hz"], 20);
    const Got beyond = post("drive", R"({"gamma_mps2": 120})");
    EXPECT_EQ(beyond.status, 409);
    EXPECT_NE(json::parse(beyond.body)["error"].get<std::string>().find("120"), std::string::npos);
    EXPECT_EQ(post("drive", R"({"gamma_mps2": "much"})").status, 400);
    EXPECT_EQ(post("drive", "{").status, 400);
    EXPECT_EQ(post("dance", "").status, 404);
    EXPECT_EQ(post("start", "").status, 200);
    EXPECT_EQ(post("start", "").status, 409);
}

TEST_F(WebOrdersTest, NumbersMayBeTextsWithUnits) {
    EXPECT_EQ(post("drive", R"({"gamma_mps2": "0.7 g", "phi_rad": "35 deg", "rho": "40 %",
                                "frequency_hz": "0.02 kHz"})")
                  .status,
              200);
    const Drive drive = std::get<service::SetDrive>(bench.ordered().back()).drive;
    EXPECT_EQ(drive.gamma, 0.7 * paper_g);
    EXPECT_EQ(drive.phi, 35 * std::numbers::pi / 180);
    EXPECT_EQ(drive.rho, 0.4);
    EXPECT_EQ(drive.frequency, 20);
    EXPECT_EQ(post("drive", R"({"gamma_mps2": "0,5 g"})").status, 200);
    EXPECT_EQ(std::get<service::SetDrive>(bench.ordered().back()).drive.gamma, 0.5 * paper_g);
    EXPECT_EQ(post("drive", R"({"gamma_mps2": "9.5"})").status, 200);
    EXPECT_EQ(std::get<service::SetDrive>(bench.ordered().back()).drive.gamma, 9.5) << "a plain text is SI";
    EXPECT_EQ(post("mu", R"({"mu": "11.3 %", "sigma": "0.001"})").status, 200);
    EXPECT_EQ(std::get<service::GiveMu>(bench.ordered().back()).mu.value, 11.3 / 100);
    EXPECT_EQ(std::get<service::GiveMu>(bench.ordered().back()).mu.sigma, 0.001);
    EXPECT_EQ(post("campaign", R"({"scan": "gamma", "from": "0.5g", "to": "1.5 g", "steps": "2",
                                   "periods": "12"})")
                  .status,
              200);
    const std::string text = std::get<service::MeasurePlan>(bench.ordered().back()).text;
    EXPECT_NE(text.find("gamma = {from = 4.9, to = 14.7"), std::string::npos) << text;
    EXPECT_NE(text.find("steps = 2}"), std::string::npos) << text;
    EXPECT_EQ(post("start", R"({"periods": "20", "measurements": "2"})").status, 200);
    EXPECT_EQ(std::get<service::Begin>(bench.ordered().back()).plan.periods, 20);
    EXPECT_EQ(std::get<service::Begin>(bench.ordered().back()).plan.measurements, 2);
}

TEST_F(WebOrdersTest, RefusedTextsNameValueUnitAndRange) {
    const auto refused = [&](const std::string& action, const std::string& body, const std::string& words) {
        const Got got = post(action, body);
        EXPECT_EQ(got.status, 400) << action << body;
        EXPECT_NE(json::parse(got.body)["error"].get<std::string>().find(words), std::string::npos)
            << got.body;
    };
    refused("drive", R"({"gamma_mps2": "200 g"})", "gamma_mps2 \"200 g\": out of range");
    refused("drive", R"({"gamma_mps2": "200 g"})", "allowed: 0.00102041 to 100 g");
    refused("drive", R"({"phi_rad": "800 deg"})", "allowed: -720 to 720 deg");
    refused("drive", R"({"phi_rad": "3 g"})", "unknown unit \"g\"");
    refused("drive", R"({"rho": 5})", "rho \"5\": out of range");
    refused("drive", R"({"rho": [5]})", "rho [5]: expected a number in SI units");
    refused("mu", R"({"mu": "500 %"})", "allowed: 0.5 to 300 %");
    refused("campaign", R"({"scan": "phi", "from": 0, "to": "900 deg", "steps": 6})",
            "to \"900 deg\": out of range");
    refused("start", R"({"periods": "2.5"})", "periods \"2.5\": expected a whole number from 3");
    refused("start", R"({"periods": "20 Hz"})", "periods \"20 Hz\": expected a whole number");
    EXPECT_TRUE(bench.ordered().empty());
}

TEST_F(WebOrdersTest, UnknownKeysAreRefusedWithTheKnownOnes) {
    const auto refused = [&](const std::string& action, const std::string& body, const std::string& words) {
        const Got got = post(action, body);
        EXPECT_EQ(got.status, 400) << action << body;
        EXPECT_EQ(json::parse(got.body)["error"], words);
    };
    refused("drive", R"({"gama_mps2": 3})",
            "gama_mps2: unknown key; expected gamma_mps2, phi_rad, rho, frequency_hz");
    refused("start", R"({"period": 20})",
            "period: unknown key; expected periods, settle_periods, measurements, gamma_mps2, phi_rad, "
            "rho, frequency_hz");
    refused("campaign", R"({"scan": "phi", "fro": 0})",
            "fro: unknown key; expected plan, scan, from, to, steps, periods, repeats");
    refused("campaign", R"({"plan": "fig3", "repeats": 2})", "repeats: unknown key; expected plan");
    refused("campaign/check", R"({"plam": "fig3"})",
            "plam: unknown key; expected plan, scan, from, to, steps, periods, repeats");
    refused("mu", R"({"mu": 0.1, "error": 0.01})", "error: unknown key; expected mu, sigma");
    refused("remark", R"({"text": "a", "at": 3})", "at: unknown key; expected text");
    refused("loop", R"({"close": true})", "close: unknown key; expected closed");
    refused("record", R"({"nam": "walk"})", "nam: unknown key; expected on, name, frames");
    refused("targets", R"({"target": []})", "target: unknown key; expected targets");
    refused("targets", R"({"targets": [{"camera": "top", "target": "walker", "region": [1, 2, 3, 4]}]})",
            "region: unknown key; expected camera, target, region_px");
    for (const char* action : {"stop", "identify", "middle", "reset-walker", "clear", "campaign/pause",
                               "campaign/stop", "control/request", "control/release"})
        refused(action, R"({"now": true})", "now: unknown key; expected none");
    EXPECT_TRUE(bench.ordered().empty());
    EXPECT_EQ(post("drive", R"({"gamma_mps2": 3, "rho": null})").status, 200);
    EXPECT_EQ(post("record", R"({"name": null})").status, 200);
}

TEST_F(WebOrdersTest, StartTakesTheKeysOfTheDriveToo) {
    EXPECT_EQ(post("start", R"({"gamma_mps2": "50 g", "periods": 12})").status, 409);
    EXPECT_EQ(json::parse(request("GET /api/state").body)["drive"]["gamma_mps2"], paper_g)
        << "nothing changed";
    EXPECT_EQ(post("start", R"({"gamma_mps2": "0.8 g", "periods": 12})").status, 200);
    const auto begin = std::get<service::Begin>(bench.ordered().back());
    ASSERT_TRUE(begin.drive);
    EXPECT_EQ(begin.drive->gamma, 0.8 * paper_g);
    EXPECT_EQ(begin.drive->frequency, 20) << "as before";
    EXPECT_EQ(begin.plan.periods, 12);
    EXPECT_EQ(json::parse(request("GET /api/state").body)["drive"]["gamma_mps2"], 0.8 * paper_g);
    EXPECT_EQ(post("stop", "").status, 200);
    EXPECT_EQ(post("start", "").status, 200);
    EXPECT_FALSE(std::get<service::Begin>(bench.ordered().back()).drive);
}

TEST_F(WebOrdersTest, AnAbortForAnotherDaemonLeavesThisOneAtRest) {
    const std::string daemon = json::parse(request("GET /api/state").body)["session"]["daemon"];
    EXPECT_EQ(daemon.size(), 16U);
    EXPECT_EQ(daemon.find_first_not_of("0123456789abcdef"), std::string::npos);
    const std::string other = "X-Shaker-Daemon: 0123456789abcdef\r\n";
    const Got refused = request("POST /api/abort", {}, other);
    EXPECT_EQ(refused.status, 409);
    EXPECT_NE(refused.body.find("the abort was for a daemon that has ended"), std::string::npos)
        << refused.body;
    EXPECT_EQ(bench.aborts, 0);
    EXPECT_EQ(request("GET /healthz").status, 200) << "it stays clear";
    EXPECT_EQ(post("start", "").status, 200);
    EXPECT_EQ(request("POST /api/abort", {}, other).status, 200) << "one that drives obeys";
    EXPECT_EQ(bench.aborts, 1);
    EXPECT_EQ(request("POST /api/abort", {}, other).status, 409) << "tripped, at rest";
    EXPECT_EQ(request("POST /api/abort", {}, "X-Shaker-Daemon: " + daemon + "\r\n").status, 200);
    EXPECT_EQ(request("POST /api/abort", {}, "X-Shaker-Daemon: \r\n").status, 200);
    EXPECT_EQ(post("abort", "").status, 200) << "without an identity it always acts";
    EXPECT_EQ(bench.aborts, 4);
}

TEST_F(WebOrdersTest, AnAbortForAnotherDaemonIsObeyedWhileOrdersWait) {
    bench.deaf = true;
    TcpClient waits{server.http_port()};
    waits.send_bytes("POST /api/start HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n");
    for (int i = 0; i < 200 && bench.bench_port.at_rest(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds{5});
    EXPECT_EQ(request("POST /api/abort", {}, "X-Shaker-Daemon: 0123456789abcdef\r\n").status, 200);
    EXPECT_EQ(bench.aborts, 1);
    bench.deaf = false;
}

TEST_F(WebOrdersTest, AbortActsWithAnyBody) {
    for (const char* body : {"", "{}", R"({"now": true})", "{", "[1]", "abort"})
        EXPECT_EQ(post("abort", body).status, 200) << body;
    EXPECT_EQ(bench.aborts, 6);
}

TEST_F(WebOrdersTest, OnlyHolderIsObeyedButAnyClientMayAbort) {
    EXPECT_EQ(post("control/request", "", "one").status, 200);
    EXPECT_EQ(post("control/request", "", "two").status, 409);
    EXPECT_EQ(post("drive", R"({"gamma_mps2": 5})", "two").status, 409);
    EXPECT_EQ(post("drive", R"({"gamma_mps2": 5})", "one").status, 200);
    EXPECT_EQ(post("abort", "", "two").status, 200);
    EXPECT_EQ(bench.aborts, 1);
    EXPECT_EQ(post("control/release", "", "one").status, 200);
    EXPECT_EQ(post("control/request", "", "two").status, 200);
}

TEST_F(WebOrdersTest, AbortIsDoneWhileOrdersWait) {
    bench.deaf = true;
    TcpClient waits{server.http_port()};
    waits.send_bytes("POST /api/start HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n");
    std::this_thread::sleep_for(std::chrono::milliseconds{20});
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_EQ(post("abort", "").status, 200);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds{500});
    EXPECT_EQ(bench.aborts, 1);
    bench.deaf = false;
    EXPECT_NE(waits.until("\r\n\r\n").find("409 Conflict"), std::string::npos)
        << "an order that was waiting at the abort is refused";
}

}  // namespace
}  // namespace shaker::remote
