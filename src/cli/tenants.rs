//! `tenants`: shows the limits of tenants with what is used of them, and gives one tenant limits of its own, beside the
//! processes that run.

use std::fmt::Write;

use clap::{Args, Subcommand};
use serde_json::{Map, Value, json};

use super::place::Place;
use super::{Exit, Failure, number, runtime, terminal};
use crate::app::{self, AppError};
use scene::{MicroUsd, TenantId};
use store::Operator;
use store::limits::{Limit, LimitChange, TenantAccount};

/// Arguments of `tenants`.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Show the limits of a tenant, or of all, and what is used of each
    Show {
        /// The tenant [default: all that have scenes, batches or limits of their own]
        tenant: Option<TenantId>,
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        place: Place,
    },
    /// Give a tenant limits of its own; running processes follow at once
    Limit {
        tenant: TenantId,
        /// Bytes of its scenes, datasets, recordings and executions; 0 for any number, `usual` for that of the settings
        #[arg(long, value_name = "BYTES", value_parser = whole_or_usual)]
        bytes: Option<OwnValue>,
        /// Jobs that wait
        #[arg(long, value_name = "JOBS", value_parser = whole_or_usual)]
        waiting_jobs: Option<OwnValue>,
        /// Jobs that run at the same time
        #[arg(long, value_name = "JOBS", value_parser = whole_or_usual)]
        running_jobs: Option<OwnValue>,
        /// Submissions in a minute
        #[arg(long, value_name = "N", value_parser = whole_or_usual)]
        submissions_per_minute: Option<OwnValue>,
        /// Cost of calls of remote models in a month, US dollars
        #[arg(long, value_name = "USD", value_parser = dollars_or_usual)]
        usd_per_month: Option<OwnValue>,
        /// Requests of its batches that have not come to their end
        #[arg(long, value_name = "N", value_parser = whole_or_usual)]
        batch_requests: Option<OwnValue>,
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        place: Place,
    },
}

/// A value of a tenant's own; `None` = that of the settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct OwnValue(Option<i64>);

/// The word for the value of the settings.
const USUAL: &str = "usual";

fn whole_or_usual(text: &str) -> Result<OwnValue, number::NumberError> {
    if text == USUAL {
        return Ok(OwnValue(None));
    }
    number::whole::<i64>(0..=i64::MAX as u64)(text).map(|value| OwnValue(Some(value)))
}

fn dollars_or_usual(text: &str) -> Result<OwnValue, number::NumberError> {
    if text == USUAL {
        return Ok(OwnValue(None));
    }
    let usd = number::us_dollars(text)?;
    if usd < 0.0 {
        return Err(number::NumberError::NotDollars);
    }
    Ok(OwnValue(Some(MicroUsd::of_usd(usd).0)))
}

/// Does it, and prints what holds now.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let (tenant, changes, as_json, place) = match arguments.action {
        Action::Show { tenant, json, place } => (tenant, Vec::new(), json, place),
        Action::Limit {
            tenant,
            bytes,
            waiting_jobs,
            running_jobs,
            submissions_per_minute,
            usd_per_month,
            batch_requests,
            json,
            place,
        } => {
            let given = [
                (Limit::Bytes, bytes),
                (Limit::WaitingJobs, waiting_jobs),
                (Limit::RunningJobs, running_jobs),
                (Limit::SubmissionsPerMinute, submissions_per_minute),
                (Limit::UsdPerMonth, usd_per_month),
                (Limit::BatchRequests, batch_requests),
            ];
            let change = |(limit, value): (Limit, Option<OwnValue>)| {
                value.map(|OwnValue(value)| LimitChange { limit, value })
            };
            let changes: Vec<LimitChange> = given.into_iter().filter_map(change).collect();
            if changes.is_empty() {
                return Err(Failure::usage(format!(
                    "give a limit, such as --waiting-jobs 100; or `{USUAL}` for that of the settings"
                )));
            }
            (Some(tenant), changes, json, place)
        }
    };
    let resolved = place.settings()?;
    let accounts = runtime()?.block_on(async {
        let mut operator = app::operator(&place.data_dir, &resolved.config).await?;
        if let Some(tenant) = tenant.as_ref().filter(|_| !changes.is_empty()) {
            operator.set_limits(tenant, &changes).await.map_err(AppError::from)?;
        }
        let accounts = accounts(&mut operator, tenant).await.map_err(AppError::from)?;
        Ok::<_, Failure>(accounts)
    })?;
    terminal::print(&if as_json { format!("{:#}\n", as_document(&accounts)) } else { as_text(&accounts) });
    Ok(Exit::Success)
}

/// The account of a tenant, or of all.
async fn accounts(
    operator: &mut Operator,
    tenant: Option<TenantId>,
) -> Result<Vec<(TenantId, Vec<TenantAccount>)>, store::StoreError> {
    let tenants = match tenant {
        Some(tenant) => vec![tenant],
        None => operator.tenants().await?,
    };
    let mut accounts = Vec::with_capacity(tenants.len());
    for tenant in tenants {
        let account = operator.account_of(&tenant).await?;
        accounts.push((tenant, account));
    }
    Ok(accounts)
}

/// The name of a limit as the options and the settings have it.
fn name_of(limit: Limit) -> &'static str {
    let setting = limit.as_str();
    setting.rsplit_once('.').map_or(setting, |(_, name)| name)
}

fn as_document(accounts: &[(TenantId, Vec<TenantAccount>)]) -> Value {
    let number = |limit: Limit, value: i64| match limit {
        Limit::UsdPerMonth => json!(MicroUsd(value).usd()),
        _ => json!(value),
    };
    let tenants = accounts.iter().map(|(tenant, account)| {
        let limits: Map<String, Value> = account
            .iter()
            .map(|TenantAccount { limit, max, is_exception, used }| {
                let facts = json!({
                    "max": (*max > 0).then(|| number(*limit, *max)),
                    "used": number(*limit, *used),
                    "is_own": is_exception,
                });
                (name_of(*limit).to_owned(), facts)
            })
            .collect();
        json!({ "tenant": tenant, "limits": limits })
    });
    json!({ "tenants": tenants.collect::<Vec<_>>() })
}

fn as_text(accounts: &[(TenantId, Vec<TenantAccount>)]) -> String {
    if accounts.is_empty() {
        return "no tenant has scenes, batches or limits of its own\n".to_owned();
    }
    let mut text = String::new();
    for (tenant, account) in accounts {
        let _ = writeln!(text, "{tenant}");
        for TenantAccount { limit, max, is_exception, used } in account {
            let shown = |value: i64| match limit {
                Limit::UsdPerMonth => MicroUsd(value).to_string(),
                _ => value.to_string(),
            };
            let max = if *max > 0 { shown(*max) } else { "any number".to_owned() };
            let own = if *is_exception { ", its own" } else { "" };
            let _ = writeln!(text, "  {}: {} of {max}{own}", name_of(*limit), shown(*used));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_numbers_none_or_the_usual_one() {
        assert_eq!(whole_or_usual("usual"), Ok(OwnValue(None)));
        assert_eq!(whole_or_usual("0"), Ok(OwnValue(Some(0))));
        assert_eq!(dollars_or_usual("12.5"), Ok(OwnValue(Some(12_500_000))));
        for text in ["-1", "", "many", "1.5"] {
            assert!(whole_or_usual(text).is_err(), "{text}");
        }
        for text in ["-1", "nan", ""] {
            assert!(dollars_or_usual(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_tenant_is_shown_with_limits_and_uses() {
        let account = |limit, max, is_exception, used| TenantAccount { limit, max, is_exception, used };
        let accounts = vec![(
            "lab".parse().expect("an id"),
            vec![
                account(Limit::Bytes, 0, false, 7),
                account(Limit::WaitingJobs, 20, true, 3),
                account(Limit::UsdPerMonth, 2_500_000, false, 1),
            ],
        )];
        let expected = "lab\n  bytes: 7 of any number\n  waiting_jobs: 3 of 20, its own\n  \
                        usd_per_month: $0.000001 of $2.500000\n";
        assert_eq!(as_text(&accounts), expected);
        let limits = &as_document(&accounts)["tenants"][0]["limits"];
        assert_eq!(limits["waiting_jobs"], json!({ "max": 20, "used": 3, "is_own": true }));
        assert_eq!((&limits["bytes"]["max"], &limits["usd_per_month"]["max"]), (&Value::Null, &json!(2.5)));
    }
}
