//! Takes every privilege from a process of root, for good.
//!
//! Root without capabilities is an ordinary user who happens to own many files, and those Landlock
//! guards. Three locks keep them away over `exec`: the bounding set is emptied, the secure bits say
//! that root is nobody special, and `no_new_privs` (set by Landlock and seccomp) forbids gaining
//! any. The first two need a privilege themselves and may be refused in a container; the third
//! suffices, which is why the refusal is not an error.

use std::io;

use rustix::thread::{
    CapabilitiesSecureBits, CapabilitySet, CapabilitySets, capabilities,
    clear_ambient_capability_set, remove_capability_from_bounding_set, set_capabilities,
    set_capabilities_secure_bits, set_no_new_privs,
};

/// Drops every capability of this process and makes sure that none is left.
pub(super) fn drop_all() -> io::Result<()> {
    set_no_new_privs(true)?;
    let _ = clear_ambient_capability_set();
    let _ = set_capabilities_secure_bits(
        CapabilitiesSecureBits::NO_ROOT
            | CapabilitiesSecureBits::NO_ROOT_LOCKED
            | CapabilitiesSecureBits::NO_SETUID_FIXUP
            | CapabilitiesSecureBits::NO_SETUID_FIXUP_LOCKED
            | CapabilitiesSecureBits::NO_CAP_AMBIENT_RAISE
            | CapabilitiesSecureBits::NO_CAP_AMBIENT_RAISE_LOCKED,
    );
    for bit in 0..u64::BITS {
        let _ = remove_capability_from_bounding_set(CapabilitySet::from_bits_retain(1 << bit));
    }
    let none = CapabilitySets {
        effective: CapabilitySet::empty(),
        permitted: CapabilitySet::empty(),
        inheritable: CapabilitySet::empty(),
    };
    set_capabilities(None, none)?;
    match capabilities(None)? == none {
        true => Ok(()),
        false => Err(io::Error::other("the kernel kept some capabilities")),
    }
}
