export default function Page() { return <h1>recordings</h1>; }
