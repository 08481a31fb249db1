#pragma once
// All commands by their headers, found at a cost that does not depend on how many there are.
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "daemon/remote/scpi/command.hpp"
#include "daemon/remote/scpi/header_pattern.hpp"
#include "daemon/remote/scpi/text.hpp"

namespace shaker::scpi {

inline constexpr std::size_t deepest = 8;  // mnemonics in a header

/// Where in the tree the last header left off: the next one of the same message begins there.
struct Path {
    std::uint32_t node = 0;
    std::uint32_t depth = 0;
    std::array<std::uint16_t, deepest> numbers{};  // behind the mnemonics so far; no_number: none
};
inline constexpr std::uint16_t no_number = 0xffff;

/// A header that was understood.
struct Found {
    const Command* command = nullptr;
    const HeaderPattern* pattern = nullptr;
    bool query = false;
    std::array<std::uint16_t, deepest> suffixes{};
    std::size_t suffix_count = 0;

    /// "SOURce:HARMonic3:AMPLitude", for messages.
    [[nodiscard]] std::string name() const;
};

/// Immutable once built; shared by all sessions.
class CommandTree {
public:
    /// Throws InputError for a pattern that cannot be read and for two rows with the same header.
    explicit CommandTree(std::vector<Command> commands);
    CommandTree(const CommandTree&) = delete;
    CommandTree& operator=(const CommandTree&) = delete;

    /// Takes the header at the begin of `text`, its ? included, and moves `path`. Takes no memory.
    /// Throws Error -101 -102 -103 -112 -113 -114.
    Found find(Text& text, Path& path) const;

    [[nodiscard]] std::span<const Command> commands() const noexcept { return commands_; }

private:
    static constexpr std::uint32_t none = 0xffffffff;
    struct Edge {
        Mnemonic word;
        std::uint32_t from = none;  // none: this place of the table is free
        std::uint32_t to = 0;
    };
    /// What stands at a node: a command, and which of the levels above carry its numbers.
    struct Leaf {
        std::uint32_t command = none;
        std::array<int, deepest> slots{};  // by level: which <...> of the header; -1: none may be given
    };

    void add(std::uint32_t command, std::size_t i, std::uint32_t node, std::size_t level, Leaf leaf);
    std::uint32_t child(std::uint32_t from, const HeaderNode& node);
    void connect(std::uint32_t from, const Mnemonic& word, std::uint32_t to);
    [[nodiscard]] std::uint32_t follow(std::uint32_t from, const Mnemonic& word) const noexcept;
    [[nodiscard]] std::size_t place(std::uint32_t from, const Mnemonic& word) const noexcept;
    [[nodiscard]] Found at_leaf(const Path& path, bool query) const;

    std::vector<Command> commands_;
    std::vector<HeaderPattern> patterns_;
    std::vector<Leaf> leaves_;
    std::vector<Edge> edges_;  // a hash table of a power of two, at most half full
    std::size_t edge_count_ = 0;
};

}  // namespace shaker::scpi
