// A function of the product: it allocates, copies, launches.
#pragma once
#include <vector>

// y = a x + y. `barrier` false: the fault that a test is to find.
void saxpy(float a, const std::vector<float>& x, std::vector<float>& y, bool barrier = true);
