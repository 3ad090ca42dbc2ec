// Stands in for pdqsort, which the source package of VAMP downloads. Only point clouds are sorted with it.
#pragma once

#include <algorithm>

template <typename... Arguments>
void pdqsort(Arguments... arguments)
{
    std::sort(arguments...);
}

template <typename... Arguments>
void pdqsort_branchless(Arguments... arguments)
{
    std::sort(arguments...);
}
