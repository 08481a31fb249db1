#pragma once
// The answers that one SCPI client waits for: each query is answered once, in order and in its form.
#include <deque>
#include <string>
#include <vector>

namespace shaker::orders {

/// A query and the form of its answer as a regular expression.
struct Query {
    std::string text, form;
};
/// Queries that are answered at once, and *OPC?, which may wait.
const std::vector<Query>& plain_queries();
/// Form of the answer to a message of the clients; empty: it has no query.
std::string form_of(const std::string& message);

class ScpiAnswers {
public:
    /// The client sent a query. withheld: its session was waiting for the answer of an earlier one.
    void asked(const std::string& form, bool withheld);
    /// An abort has dropped the withheld messages, ABORt? excepted. The session may wait for the first
    /// answer.
    void dropped();
    /// The session ended.
    void forget() { owed_.clear(); }
    /// The session does not wait: nothing is withheld.
    void nothing_withheld();
    /// A line that the client received. Returns a sentence about what is wrong; empty: the answer is right.
    std::string take(const std::string& line);
    /// Form of the first answer that is due; empty: none.
    [[nodiscard]] std::string due() const;

private:
    struct Owed {
        std::string form;
        bool withheld, optional;
    };
    std::deque<Owed> owed_{};
};

}  // namespace shaker::orders
