//! The dining and kitchen family: dishes, cutlery, cookware, bottles, fruit, bread, packages.

use super::Generator;

mod assembly;
mod vessels;
mod cutlery;
mod fruit;
mod pots;
mod bottles;
mod cookware;
mod bakery;
mod packages;

pub(crate) use assembly::vessel;

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
    ("teapot", pots::teapot),
    ("kettle", pots::kettle),
    ("pitcher", pots::pitcher),
    ("water_bottle", bottles::water_bottle),
    ("wine_bottle", bottles::wine_bottle),
    ("soda_can", bottles::soda_can),
    ("jar", bottles::jar),
    ("salt_shaker", bottles::salt_shaker),
    ("pepper_mill", bottles::pepper_mill),
    ("cutting_board", cookware::cutting_board),
    ("frying_pan", cookware::frying_pan),
    ("saucepan", cookware::saucepan),
    ("spatula", cookware::spatula),
    ("ladle", cookware::ladle),
    ("whisk", cookware::whisk),
    ("rolling_pin", cookware::rolling_pin),
    ("bread_loaf", bakery::bread_loaf),
    ("baguette", bakery::baguette),
    ("cheese_wedge", bakery::cheese_wedge),
    ("croissant", bakery::croissant),
    ("donut", bakery::donut),
    ("cake", bakery::cake),
    ("napkin_holder", packages::napkin_holder),
    ("toaster", packages::toaster),
    ("milk_carton", packages::milk_carton),
    ("cereal_box", packages::cereal_box),
    ("tray", packages::tray),
    ("basket", packages::basket),
];
