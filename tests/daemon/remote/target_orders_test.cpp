// Regions of targets as orders over HTTP.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "daemon/remote/server.hpp"
#include "daemon/remote/web/state_json.hpp"
#include "tests/support/remote/played_bench.hpp"
#include "tests/support/remote/tcp_client.hpp"

namespace shaker::remote {
namespace {

struct TargetOrdersTest : testing::Test {
    test::PlayedBench bench;
    Server server{bench.bench_port, {.http_port = 0, .scpi_port = 0}};

    int status_of(const std::string& body) {
        test::TcpClient client{server.http_port()};
        client.send_bytes(
            "POST /api/targets HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: " +
            std::to_string(body.size()) + "\r\n\r\n" + body);
        return std::stoi(client.rest().substr(9, 3));
    }
};

TEST_F(TargetOrdersTest, AllRegionsAreOneOrder) {
    EXPECT_EQ(status_of(R"({"targets":[{"camera":"top","target":"walker","region_px":[4,2,18,17]},
                                       {"camera":"side","target":"base","region_px":[1,2,3,4.5]}]})"),
              200);
    const auto order = std::get<service::MoveTargets>(bench.ordered().back());
    ASSERT_EQ(order.targets.size(), 2U);
    EXPECT_EQ(text(order.targets[0]), "camera \"top\", target \"walker\", roi_px = [4, 2, 18, 17]");
    EXPECT_EQ(text(order.targets[1]), "camera \"side\", target \"base\", roi_px = [1, 2, 3, 4.5]");
}

TEST_F(TargetOrdersTest, IncompleteRegionsAreNoOrder) {
    for (const char* wrong :
         {R"({})", R"({"targets":1})", R"({"targets":[1]})", R"({"targets":[{"camera":"top"}]})",
          R"({"targets":[{"camera":"top","target":"walker","region_px":[1,2,3]}]})",
          R"({"targets":[{"camera":"top","target":"walker","region_px":[1,2,3,"4"]}]})"})
        EXPECT_EQ(status_of(wrong), 400) << wrong;
    EXPECT_TRUE(bench.ordered().empty());
}

// The proposed region has moved with its target; a lost target has none.
TEST_F(TargetOrdersTest, StateHasRegionsAndProposals) {
    service::BenchFacts facts;
    facts.views = {{.camera = "top",
                    .targets = {{.name = "walker", .roi_px = {10, 20, 30, 40}}, {.name = "base"}},
                    .origin_px = {0, 8}}};
    service::BenchState state;
    state.facts = std::make_shared<const service::BenchFacts>(facts);
    state.pictures_now = {{.camera = "top",
                           .frame = std::make_shared<Frame>(),
                           .fixes = {},
                           .targets = {},
                           .regions_now = {std::array{15, 20, 30, 40}, std::nullopt}}};
    const auto camera = nlohmann::json::parse(web::state_json(state, {}))["cameras"][0];
    EXPECT_EQ(camera["height_px"], 0);
    EXPECT_EQ(camera["origin_px"], (std::array{0, 8}));
    EXPECT_EQ(camera["targets"][0]["region_px"], (std::array{10, 20, 30, 40}));
    EXPECT_EQ(camera["targets"][0]["proposed_px"], (std::array{15, 20, 30, 40}));
    EXPECT_TRUE(camera["targets"][1]["proposed_px"].is_null());
}

}  // namespace
}  // namespace shaker::remote
