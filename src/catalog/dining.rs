//! The dining and kitchen family: dishes, cutlery, cookware, bottles, fruit, bread, packages.

use super::Generator;

mod assembly;
mod vessels;
mod cutlery;
mod fruit;

/// Name of the category and the function that builds it.
pub const GENERATORS: &[(&str, Generator)] = &[
    ("mug", vessels::mug),
    ("teacup", vessels::teacup),
    ("saucer", vessels::saucer),
    ("drinking_glass", vessels::drinking_glass),
    ("wine_glass", vessels::wine_glass),
    ("plate", vessels::plate),
    ("bowl", vessels::bowl),
    ("fork", cutlery::fork),
    ("knife", cutlery::knife),
    ("spoon", cutlery::spoon),
    ("chopsticks", cutlery::chopsticks),
    ("apple", fruit::apple),
    ("orange", fruit::orange),
    ("pear", fruit::pear),
    ("lemon", fruit::lemon),
    ("banana", fruit::banana),
    ("tomato", fruit::tomato),
    ("egg", fruit::egg),
    ("carrot", fruit::carrot),
    ("cucumber", fruit::cucumber),
];
