// Stands in for the library Nigh, which the source package of VAMP downloads: the same interface over a linear scan.
//
// The trees of these problems hold tens to hundreds of nodes, and VAMP's own k-d tree scans leaves of 128.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace unc::robotics::nigh
{
    struct NoThreadSafety
    {
    };

    template <std::size_t batch>
    struct KDTreeBatch
    {
    };

    namespace metric
    {
        template <int p>
        struct LP
        {
        };

        template <typename Type, typename Metric>
        struct Space;
    }  // namespace metric

    template <typename T, typename Space, typename KeyOf, typename Concurrency, typename Strategy>
    class Nigh
    {
    public:
        void insert(const T &node)
        {
            nodes_.push_back(node);
        }

        auto size() const -> std::size_t
        {
            return nodes_.size();
        }

        auto nearest(const typename Space::Type &key) const
            -> std::optional<std::pair<T, typename Space::Distance>>
        {
            auto least = std::numeric_limits<typename Space::Distance>::infinity();
            const T *best = nullptr;
            for (const auto &node : nodes_)
            {
                const auto distance = Space::distance(KeyOf()(node), key);
                if (distance < least)
                {
                    least = distance;
                    best = &node;
                }
            }
            return best ? std::optional(std::make_pair(*best, least)) : std::nullopt;
        }

    private:
        std::vector<T> nodes_;
    };
}  // namespace unc::robotics::nigh
