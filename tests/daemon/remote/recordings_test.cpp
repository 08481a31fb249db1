// The list of recordings over HTTP: names, downloads and replays; a script stands for shakerd.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "daemon/remote/server.hpp"
#include "tests/support/program.hpp"
#include "tests/support/remote/played_bench.hpp"
#include "tests/support/remote/tcp_client.hpp"

namespace shaker::remote {
namespace {

using nlohmann::json;

constexpr const char* script = R"(#!/bin/sh
case $1 in
list) echo '{"outcome":"3 measurements","remarks":["new paper"],"results":[{"time":"2026-11-26T10:00:00Z","asked":{"phi_rad":1}}]}' ;;
replay) printf '3 measurements:\nidentical to the bit\n'; exit $(cat "$2" | wc -c | grep -q '^300000$'; echo $?) ;;
esac
)";

struct RecordingsTest : testing::Test {
    RecordingsTest() {
        std::ofstream{folder / "big.nxs"} << std::string(300000, 'x');
        std::ofstream{folder / "small.nxs"} << "y";
        std::ofstream{folder / "notes.txt"} << "secret";
        std::ofstream{folder / ".hidden.nxs"} << "secret";
        std::filesystem::create_symlink(folder / "notes.txt", folder / "link.nxs");
        std::ofstream{program} << script;
        chmod(program.c_str(), 0700);
    }
    std::string get(const std::string& path, const std::string& method = "GET",
                    const std::string& client = "a") {
        test::TcpClient connection{server().http_port()};
        connection.send_bytes(method + " " + path + " HTTP/1.1\r\nHost: localhost\r\nX-Shaker-Client: " +
                              client + "\r\nConnection: close\r\nContent-Length: 0\r\n\r\n");
        return connection.rest();
    }
    static std::string body(const std::string& answer) { return answer.substr(answer.find("\r\n\r\n") + 4); }
    json recording(const std::string& name) {
        const json all = json::parse(body(get("/api/recordings")));
        for (const json& r : all["recordings"])
            if (r["name"] == name) return r;
        return {};
    }
    json wait_for(const std::string& name, const char* key) {
        json r;
        for (int i = 0;
             i < 400 && (r.is_null() || r[key].is_null() || r[key] == "waiting" || r[key] == "running");
             ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds{50});
            r = recording(name);
        }
        return r;
    }
    Server& server() { return *server_; }

    const std::filesystem::path folder = test::fresh_folder(), program = folder / "shakerd";
    std::atomic<bool> rest{true};
    test::PlayedBench bench;

    void serve() {
        recordings_ = std::make_unique<catalogue::Catalogue>(
            catalogue::CatalogueSettings{
                .folder = folder, .program = program, .may_read = [this] { return rest.load(); }},
            bench.bench_port.results());
        server_ = std::make_unique<Server>(bench.bench_port, ServerSettings{.http_port = 0, .scpi_port = 0},
                                           recordings_.get());
    }

private:
    std::unique_ptr<catalogue::Catalogue> recordings_;
    std::unique_ptr<Server> server_;
};

TEST_F(RecordingsTest, ListHasWhatTheFilesHold) {
    serve();
    wait_for("small.nxs", "outcome");
    const json r = wait_for("big.nxs", "outcome");
    EXPECT_EQ(r["outcome"], "3 measurements");
    EXPECT_EQ(r["bytes"], 300000);
    EXPECT_EQ(r["remarks"], json({"new paper"}));
    EXPECT_EQ(r["set_points"][0]["phi_rad"], 1);
    EXPECT_EQ(r["trouble"], nullptr);
    EXPECT_TRUE(recording("link.nxs").is_null()) << "a link is not followed";
    EXPECT_TRUE(recording(".hidden.nxs").is_null());
    EXPECT_EQ(json::parse(body(get("/api/results")))["results"].size(), 2U) << "of the recordings of before";
}

TEST_F(RecordingsTest, DownloadsResolveInsideTheFolder) {
    serve();
    const std::string big = get("/api/recordings/big.nxs");
    EXPECT_TRUE(big.starts_with("HTTP/1.1 200")) << big.substr(0, 200);
    EXPECT_NE(big.find("Content-Length: 300000\r\n"), std::string::npos);
    EXPECT_EQ(body(big), std::string(300000, 'x'));
    for (const char* name : {"notes.txt", "link.nxs", ".hidden.nxs", "../x.nxs", "..%2fx.nxs", "none.nxs", "",
                             "/etc/passwd", "shakerd", "sub/big.nxs"}) {
        const std::string answer = get(std::string{"/api/recordings/"} + name);
        EXPECT_TRUE(answer.starts_with("HTTP/1.1 404")) << name << ": " << answer.substr(0, 100);
        EXPECT_EQ(answer.find("secret"), std::string::npos) << name;
    }
}

TEST_F(RecordingsTest, ReplayNeedsControlAndTellsItsVerdict) {
    serve();
    wait_for("big.nxs", "outcome");
    EXPECT_TRUE(get("/api/control/request", "POST", "b").starts_with("HTTP/1.1 200"));
    EXPECT_TRUE(get("/api/recordings/big.nxs/replay", "POST").starts_with("HTTP/1.1 409"));
    EXPECT_TRUE(get("/api/recordings/big.nxs/replay", "POST", "b").starts_with("HTTP/1.1 200"));
    EXPECT_TRUE(get("/api/recordings/small.nxs/replay", "POST", "b").starts_with("HTTP/1.1 200"));
    EXPECT_TRUE(get("/api/recordings/none.nxs/replay", "POST", "b").starts_with("HTTP/1.1 409"));
    const json r = wait_for("big.nxs", "replay");
    EXPECT_EQ(r["replay"], "identical");
    EXPECT_EQ(r["replay_text"], "identical to the bit");
    EXPECT_EQ(wait_for("small.nxs", "replay")["replay"], "failed");
}

TEST_F(RecordingsTest, NothingIsReadWhileTheDriveIsOn) {
    rest = false;
    serve();
    for (const char* method : {"GET", "POST"}) {
        const std::string answer =
            get(std::string{"/api/recordings/big.nxs"} + (*method == 'P' ? "/replay" : ""), method);
        EXPECT_TRUE(answer.starts_with("HTTP/1.1 409")) << answer;
        EXPECT_NE(answer.find("only while nothing is driven"), std::string::npos) << answer;
    }
    EXPECT_EQ(recording("big.nxs")["outcome"], nullptr);
}

}  // namespace
}  // namespace shaker::remote
