#pragma once
// What an operator reads while a campaign is measured, and the words that the operator gives meanwhile: keys
// of a terminal, or lines of another standard input.
#include <termios.h>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/campaign/lead/campaign.hpp"
#include "daemon/campaign/points_table.hpp"

namespace shaker::commands {

/// One line for each point that ends, each pause and each problem, at once, also into a pipe. On a terminal
/// there is a last line that is written again and again: point, what the bench does, time left, last v_D.
class CampaignLines {
public:
    /// bench_s: predicted bench time of each point.
    CampaignLines(const campaign::Engine& engine, const std::vector<campaign::Point>& points,
                  std::vector<double> bench_s);
    ~CampaignLines();
    CampaignLines(const CampaignLines&) = delete;
    CampaignLines& operator=(const CampaignLines&) = delete;

    void event(const campaign::Event& event, double now_s);
    /// An answer to the operator.
    void say(const std::string& sentence);
    /// Writes the last line again if it is old. spent_s: bench time of the points so far, without that at
    /// rest.
    void status(double spent_s);
    /// Predicted time of the points that are left, corrected by the time that the ended points have taken; s.
    [[nodiscard]] double left_s(double spent_s) const;

private:
    void print(const std::string& line);

    const campaign::Engine& engine_;
    const std::vector<campaign::Point>& points_;
    std::vector<double> bench_s_;
    std::vector<bool> ended_ = std::vector<bool>(bench_s_.size(), false);
    bool terminal_;
    double written_s_ = -1;  // monotonic time of the last line
    std::string last_;       // v_D of the newest point
};

/// Share of the points, bench time by its use, accuracy of the returns, v_D against the simulated truth.
std::string campaign_summary(const campaign::PointsTable& table, const campaign::BenchTime& time,
                             const std::vector<campaign::Returned>& returns, double wall_s);

/// A key and the word for which it stands.
using Keys = std::vector<std::pair<char, std::string>>;

/// On a terminal each key acts at once, without an echo, during the life of this object. A program in the
/// background of a terminal has no input. Thread safety: one thread.
class OperatorInput {
public:
    explicit OperatorInput(Keys keys);
    ~OperatorInput();
    OperatorInput(const OperatorInput&) = delete;
    OperatorInput& operator=(const OperatorInput&) = delete;

    /// Returns the next word, or nothing when none has come yet. With `waits` it first waits until a word,
    /// the end of the input or a signal comes.
    std::optional<std::string> next(bool waits);
    /// The input has ended.
    [[nodiscard]] bool closed() const noexcept { return closed_; }
    /// Standard input is a terminal.
    [[nodiscard]] bool keys() const noexcept { return before_.has_value(); }

private:
    std::optional<std::string> word_in_text();

    Keys keys_;
    std::optional<termios> before_;  // of the terminal
    std::string text_;
    bool closed_ = false;
};

}  // namespace shaker::commands
